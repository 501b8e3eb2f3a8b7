"""A plan as people see it: as text, as a Mermaid flow chart, as an SVG picture."""

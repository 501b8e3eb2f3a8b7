"""Single checks of a graph: files, interfaces, reproducibility, and warnings."""

"""Single checks of a graph: inputs of stages, files, interfaces, reproducibility, and warnings."""

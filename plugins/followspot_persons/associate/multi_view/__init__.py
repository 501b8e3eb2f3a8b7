"""Several cameras: their matrices, triangulation and the errors of points."""

"""A target that one view alone shows: its place on the ray, and whether it keeps to its course."""

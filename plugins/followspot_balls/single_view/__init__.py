"""A target that one view alone shows: its position on the ray, and whether it keeps to its steady motion."""

"""Points, boxes and joints that other programs find, markers, and their positions in space."""

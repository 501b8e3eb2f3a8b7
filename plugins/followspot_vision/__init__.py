"""Points, boxes and joints that other programs find, markers, and what makes positions in space of them."""

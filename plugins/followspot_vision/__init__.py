"""Points, boxes and joints that other programs find, and what makes positions in space of them."""

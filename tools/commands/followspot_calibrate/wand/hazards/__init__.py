"""What goes wrong when a wand is waved: how each mistake shows in the points, and what to do about it."""

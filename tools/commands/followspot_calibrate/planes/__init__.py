"""`calibrate planes`: plane equations from points on them that several cameras see."""

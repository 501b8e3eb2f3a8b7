"""`calibrate intrinsics`: matrix and distortion of a lens from views of a board (Zhang 2000)."""

"""`followspot calibrate targets`: templates of the targets from clips of each of them alone."""

"""`calibrate targets`: templates from clips of each target alone."""

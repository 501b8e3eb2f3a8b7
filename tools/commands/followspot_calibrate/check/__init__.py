"""`calibrate check`: how good is a room file now, by points, by ordinary tracking, by another calibration."""

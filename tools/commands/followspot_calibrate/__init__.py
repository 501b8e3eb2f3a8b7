"""`followspot calibrate ...`: from cameras on a truss to a room file; a folder for each command."""

"""`followspot room import`: a room file from a calibration that another program wrote."""

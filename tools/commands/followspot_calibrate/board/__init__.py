"""`calibrate board`: where cameras stand, from a board that several of them see at once."""

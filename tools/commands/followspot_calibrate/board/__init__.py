"""`calibrate board`: camera poses from a board that several cameras see at once."""

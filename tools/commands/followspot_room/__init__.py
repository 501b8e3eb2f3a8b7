"""`followspot room ...`: room files from videos and from calibrations of other programs, and back again."""

"""By whose clock a run on several hosts goes, and how far the others are from it."""

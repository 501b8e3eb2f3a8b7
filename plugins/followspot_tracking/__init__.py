"""Tracks of several trackers that share one frame of reference."""

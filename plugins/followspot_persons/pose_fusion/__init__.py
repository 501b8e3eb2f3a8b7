"""Fusion of the poses of several cameras: their table, and the Kalman filter of a position on the floor."""

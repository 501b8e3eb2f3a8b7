"""Filters of the package filterpy in place of `balls.kalman`, to compare models of motion."""

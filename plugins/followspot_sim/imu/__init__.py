"""Inertial sensors on the balls of the simulated room."""

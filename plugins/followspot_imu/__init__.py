"""Inertial sensors: sources of readings, and the orientation that follows from them."""

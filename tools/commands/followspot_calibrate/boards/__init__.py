"""Calibration boards: what they are, where their corners are seen, and the pictures that show them."""

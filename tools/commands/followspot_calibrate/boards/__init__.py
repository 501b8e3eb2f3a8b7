"""Calibration boards, detection of their corners, and the pictures that show them."""

"""Throws: parabolas among the measured positions."""

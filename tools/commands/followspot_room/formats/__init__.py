"""Formats of calibrations, a module each: how it is recognised, read and written."""

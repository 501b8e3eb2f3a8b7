"""Sinks that write CSV files."""

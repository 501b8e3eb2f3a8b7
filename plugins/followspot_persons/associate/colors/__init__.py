"""Colours of torsos."""

"""Typical mistakes with a wand: how each shows in the points, and what to do about it."""

"""Capture times that were written down beside recorded pictures: tables, lists, and names of files."""

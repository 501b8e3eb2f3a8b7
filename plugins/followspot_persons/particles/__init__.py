"""The particle filter of one person's pose."""

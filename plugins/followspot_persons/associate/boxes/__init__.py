"""Bodies that are measured as boxes."""

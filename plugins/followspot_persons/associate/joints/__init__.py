"""Bodies that are measured as joints."""

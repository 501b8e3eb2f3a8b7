"""`followspot new`: a plugin package, or a stage in one, with tests that pass."""

"""`followspot new`: a plugin package, or a stage in one, whose first test run is green."""

"""`followspot compare`: variants of a graph on the same recordings, against ground truth."""

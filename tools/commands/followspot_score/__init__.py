"""`followspot score`: tracks and poses against ground truth."""

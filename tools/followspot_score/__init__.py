"""`followspot score`: tracks against ground truth."""

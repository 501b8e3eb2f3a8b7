"""`followspot train`: makes the weights that detectors of people ship with."""

"""Taps at the ports of a worker: their messages also go to observers, beside the graph."""

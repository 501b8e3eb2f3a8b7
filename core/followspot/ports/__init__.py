"""Ports of a stage: marks in the signature of `process`, the ports that it declares, records of firings."""

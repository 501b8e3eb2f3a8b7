"""Changes to a run that the operator leads through all its hosts: swaps, files of sub-graphs, moves."""

"""Changes to the plan of a running graph: other stages, parameters, workers, files of sub-graphs."""

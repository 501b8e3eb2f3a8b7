"""Help of the argument that names a run."""

RUN = "the graph, the beginning of the run's name, or its process id, if several runs go on"

"""How a run is named on the command line."""

RUN = "the graph, the beginning of the run's name, or its process, where several run"

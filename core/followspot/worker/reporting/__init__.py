"""Reports of a worker to its host: progress, status of stages, and the final report."""

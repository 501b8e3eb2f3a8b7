"""What a worker tells its host: progress, status of stages, and its report at the end."""

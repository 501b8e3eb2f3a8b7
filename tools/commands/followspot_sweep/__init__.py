"""A graph over a grid of parameters: `followspot sweep`."""

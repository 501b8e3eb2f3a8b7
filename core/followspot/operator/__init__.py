"""A run that changes while it goes on: stages swapped or moved, parameters set."""

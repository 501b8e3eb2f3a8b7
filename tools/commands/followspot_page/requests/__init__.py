"""The requests of one browser, and their answers."""

"""Runners: one for each kind of stage, which calls it and sends what it gives."""

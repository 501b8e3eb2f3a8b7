"""Runners: one for each kind of stage. A runner calls its stage and sends the results."""

"""The ports of a stage: the marks in the signature of `process`, and the ports that are read from it."""

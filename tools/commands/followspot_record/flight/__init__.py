"""The flight recorder: the last seconds of a run in memory, and the moments of it that are marked."""

"""The reference clock of a run on several hosts, and the offsets of the other hosts' clocks from it."""

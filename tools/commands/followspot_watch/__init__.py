"""Looking at a run from a terminal, on this machine or from another one."""

"""Changes while a worker runs: what is new is built beside what works, then put in between two firings."""

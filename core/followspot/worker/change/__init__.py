"""Changes while a worker runs: new stages are built beside the old, and take over between two firings."""

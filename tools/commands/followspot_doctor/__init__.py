"""`followspot doctor`: what would keep a graph from running here, each with a remedy."""

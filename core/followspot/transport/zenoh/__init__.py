"""Edges between hosts, sessions, and who may do what on them; imported only if a run needs Zenoh."""

"""Edges between hosts, Zenoh sessions and access control; imported only if a run needs Zenoh."""

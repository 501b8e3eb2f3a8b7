"""Edges between processes of one host: shared memory, and datagrams that tell what lies in it."""

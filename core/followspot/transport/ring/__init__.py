"""Edges between processes of one host: shared memory, and small datagrams that say what lies in it."""

"""Ports of a graph to and from one MCAP file (docs/recordings.md); needs the extra `recording`."""

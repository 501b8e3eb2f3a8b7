"""Taps: previews of a graph's messages for observers. They never wait and cost nothing without observers."""

"""Taps: previews of what a graph sends, for those who look on. They never wait and cost nothing unwatched."""

"""The document of a room: read as a `Room`, with every mistake at its place, and written."""

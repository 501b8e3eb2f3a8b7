"""From the document of a room to a `Room`, with every mistake at its place; a file for each section."""

"""The room without people, and the foreground: the regions that differ from it."""

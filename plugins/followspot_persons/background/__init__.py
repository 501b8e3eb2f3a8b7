"""The room without people, and what differs from it."""

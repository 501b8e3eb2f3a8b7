"""The contents of the page: the room, the newest of each message in JSON, and curves of their figures."""

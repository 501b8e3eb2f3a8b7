"""What browsers draw: the room, the newest of each message in JSON, and curves of their figures."""

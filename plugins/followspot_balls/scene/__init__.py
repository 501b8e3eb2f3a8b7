"""What the room and the forecast tell of the scene: planes, and radius and state of each target."""

"""The model of an upper body: its shape, its image in a camera, and its height."""

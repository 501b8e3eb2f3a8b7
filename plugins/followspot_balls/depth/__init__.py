"""Balls in a depth image: spheres of their radius before the empty room."""

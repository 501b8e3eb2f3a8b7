"""Rendering of a simulated scene in pictures and depth: light, people, balls and occlusion."""

"""Numbered slots for shows, which keep their object: lights, sound and pictures are patched to numbers."""

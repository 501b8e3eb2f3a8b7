"""Persons in a simulated room: bodies, clothes, furniture, and their pictures."""

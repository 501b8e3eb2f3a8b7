"""Persons in a simulated room: bodies, clothes, furniture, and what cameras see of them."""

"""Colour of upper bodies: models, differences and likelihoods."""

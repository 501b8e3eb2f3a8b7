"""Smoothing of tracks by later positions."""

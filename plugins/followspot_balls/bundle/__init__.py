"""Fusion by bundle adjustment of all sightings of a target."""

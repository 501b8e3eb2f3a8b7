"""Corrects small errors of cameras by the sightings of an ordinary tracking run."""

"""Sightings of points by several cameras: the input of every calibration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.messages import Array


@dataclass(frozen=True, eq=False)
class Sightings:
    """Points as the cameras saw them; a row is one point of the room at one moment.

    cameras: names, C of them; sizes: (C, 2) px, width and height;
    frame: (N,) int64, rows with the same frame were seen at the same time; label: (N,) int64, which point
    of the object it is (0 for a single bulb; 0 and 1 for a wand of two; a corner's number on a board);
    pixel: (N, C, 2) px with lens distortion, NaN if the camera did not see the point.
    """

    cameras: tuple[str, ...]
    sizes: Array
    frame: Array
    label: Array
    pixel: Array

    @property
    def seen(self) -> Array:
        """(N, C) bool: which camera saw which point."""
        return np.asarray(np.isfinite(self.pixel[..., 0]))

    def rows(self, chosen: Array) -> Sightings:
        """Some of the rows, by mask or index."""
        return Sightings(self.cameras, self.sizes, self.frame[chosen], self.label[chosen], self.pixel[chosen])

"""A picture compared with the background: regions that differ show people, or things that were moved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot_persons.background.background import Background, foreground
from followspot_persons.panorama import full_turn, short_way, turn_of


@dataclass(frozen=True, eq=False)
class Scene:
    """pixels, background: (H, W, 3) u1; light: how bright the picture is over the background."""

    camera: Camera
    pixels: Array
    background: Array
    light: float

    @classmethod
    def of(cls, camera: Camera, pixels: Array, background: Background) -> Scene | None:
        """The scene of a picture; None while the background is unknown."""
        light = background.light(pixels)
        if background.median is None or light is None:
            return None
        return cls(camera, pixels, background.median, light)

    def mask(self, step: int) -> Array:
        """Foreground at one pixel of so many in each row and column, (H / step, W / step) bool."""
        return foreground(self.pixels[::step, ::step], self.background[::step, ::step], self.light)

    def changed(self, rows: Array, columns: Array) -> Array:
        """Foreground at the pixels of these rows and columns, which go on round a panorama; none beyond the
        picture's sides.
        """
        width = self.camera.size[0]
        wraps = full_turn(self.camera)
        inside = np.ones(columns.shape, bool) if wraps else (columns >= 0) & (columns < width)
        there = rows, columns % width if wraps else np.clip(columns, 0, width - 1)
        return foreground(self.pixels[there], self.background[there], self.light) & inside

    def beside(self, columns: Array, boxes: Array, half: float) -> Array:
        """Which columns (...) are farther than `half` heights from the middle of all boxes, (K, 4) px."""
        free = np.ones(columns.shape, bool)
        for x0, y0, x1, y1 in boxes.tolist():
            away = short_way(columns - (x0 + x1) / 2, turn_of(self.camera))
            free &= np.abs(away) >= half * (y1 - y0)
        return free

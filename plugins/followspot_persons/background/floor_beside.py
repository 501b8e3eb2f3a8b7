"""Where a person stands by the floor about its feet in one picture; no background is needed.

The floor beside the legs and before the feet shows its colours. Legs end where their place has no other
colours than these.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_persons.background.background import foreground
from followspot_persons.background.body_axis import Axis, distance_on_floor
from followspot_persons.background.floor_contact import (
    ASTRIDE,
    GAP,
    SHARE,
    Contact,
    lowest,
    moved,
)
from followspot_persons.background.goes_on import goes_on_below
from followspot_persons.body.view import HEIGHT
from followspot_persons.panorama import full_turn, short_way, turn_of

FIRST, LAST = 1.5, 0.7
"""Distances at which feet are looked for, over that of the pose."""
NEAREST, FARTHEST = 0.75, 1.45
"""Distances at which they are found, over that of the pose: the box of a body may be too large by a third."""
FLOOR = 0.9
"""The same from which on the floor tells its colours: a person may seem farther away than it stands."""
BEFORE = 0.5
"""Rows of this floor, in heights of the upper body."""
LEAST_BEFORE = 0.07
"""The same that the picture shows at least."""
WIDTH = 0.22
"""Half the width of the legs' strip, in heights of the upper body."""
BESIDE, ASIDE = 0.42, 1.0
"""Nearest and farthest column of the floor beside the legs, from the axis, in the same unit."""
OTHERS = 0.5
"""Half the width of a nearer person's columns, in heights of its upper body."""
FREE, SEEN = 0.9, 0.3
"""Shares of the legs' strip, and of the floor, that nearer people must leave."""
COLORS = 60
"""Pixels of the floor that tell its colours."""
ALIKE = 0.04
"""Share of them of which one has to be for a pixel to be of the floor."""
SHADOW = 0.6
"""Brightness of the floor's shadow below a shoe over that of the floor, at least."""
FILLED = 0.9
"""Share of the rows of legs that are unlike the floor."""
GOES_ON = 0.6
"""Share of floor at each side of the legs, above the feet: things that hide feet also hide this floor."""
ABOVE = 0.25
"""Height of these rows, in heights of the upper body."""
LAG = 0.1
"""Distance by which the lowest row that differs from the floor is behind the foot, m: shoes and their shadow
resemble some floors."""
BEFORE_FEET = 0.75, 0.6
"""Distances between which nothing of a person may be, over that of the pose: something is there below 0.3 %
of the weak boxes of whole upper bodies, and the rest of the body below 72 % of those of heads or chests.
"""
AWAY = 1.2, 2.5
"""Nearest and farthest column of the floor beside this rest, from the axis, in heights of the upper body."""
UNLIKE = 0.4
"""Share of the strip there that is unlike the floor if a body is there."""


def contact_beside(camera: Camera, pixels: Array, pose: Array, others: Array) -> Contact | None:
    """Where a person stands by the floor about its feet; None if the picture does not show them on a floor.

    pixels: (H, W, 3) u1 BGR; pose: (6,), about where the person is; others: (K, 4) px, upper bodies of nearer
    people.
    """
    by_size = float(np.hypot(*(pose[:2] - camera.center[:2])))
    pose = _with_floor(camera, pose)
    axis = Axis.of(camera, pose)
    if axis is None:
        return None
    legs = _Legs(camera, pixels, axis, others)
    first, floor_row, last = (_row(camera, pose, share) for share in (FIRST, FLOOR, LAST))
    low = None if _before(legs, pose) else legs.lowest(first, floor_row, last)
    floor = None if low is None else distance_on_floor(camera, axis, low)
    if floor is None:
        return None
    distance = floor - LAG
    return Contact(distance) if NEAREST * by_size <= distance <= FARTHEST * by_size else None


def _with_floor(camera: Camera, pose: Array) -> Array:
    """The pose (6,), moved away until the picture shows the floor before its feet.

    If the distance is estimated too small, the floor before the feet would lie below the picture.
    """
    axis = Axis.of(camera, pose)
    if axis is None:
        return pose
    lowest_row = camera.size[1] - 1 - max(2, round(LEAST_BEFORE * axis.tall))
    nearest = distance_on_floor(camera, axis, lowest_row)
    share = 0.0 if nearest is None else nearest / (FLOOR * float(np.hypot(*(pose[:2] - camera.center[:2]))))
    eye = camera.center
    height = float(eye[2] + share * (pose[HEIGHT] - eye[2]))
    return pose if nearest is None or share <= 1 else moved(pose, eye, nearest / FLOOR, height)


def body_before(camera: Camera, pixels: Array, pose: Array, others: Array) -> bool:
    """Whether a body goes on in the picture below where the feet of a pose (6,) would be, with floor beside
    it: the pose is of a head or a chest of somebody nearer. Arguments of :func:`contact_beside`.
    """
    axis = Axis.of(camera, pose)
    return axis is not None and _before(_Legs(camera, pixels, axis, others), pose)


def _before(legs: _Legs, pose: Array) -> bool:
    """Whether the legs of a pose go on before its feet."""
    first, last = (_row(legs.camera, pose, share) for share in BEFORE_FEET)
    return legs.go_on(np.arange(first, last))


def _row(camera: Camera, pose: Array, share: float) -> int:
    """Row of the floor in the direction of a pose, at a share of its distance, within the picture."""
    place = camera.center[:2] + share * (pose[:2] - camera.center[:2])
    row, height = float(project(camera, np.array([[*place, 0.0]]))[0, 1]), camera.size[1]
    return int(np.clip(row, 0, height)) if np.isfinite(row) else height


@dataclass(frozen=True, eq=False)
class _Legs:
    """The picture about the legs of a person. pixels, others: of :func:`contact_beside`."""

    camera: Camera
    pixels: Array
    axis: Axis
    others: Array

    def lowest(self, first: int, floor: int, last: int) -> int | None:
        """The lowest row of the legs; None if they are not seen from above down to the feet.

        first, last: rows between which they are sought; floor: row below which the floor shows its colours.
        """
        tall, height = self.axis.tall, self.pixels.shape[0]
        rows, half = np.arange(first, last), round(WIDTH * tall)
        below = np.arange(floor, min(height, floor + round(BEFORE * tall)))
        if len(rows) < ABOVE * tall or len(below) < 2:
            return None
        beside = self._beside(below)
        strip, seen = self.axis.beside(rows, half), self._free(beside)
        if self._free(strip).mean() < FREE or seen.mean() < SEEN:
            return None
        colors = self._at(below, beside)[seen]
        colors = colors[np.linspace(0, len(colors) - 1, COLORS).astype(int)]
        filled = self._unlike(colors, rows, strip).mean(axis=1) >= SHARE
        gap = max(1, round(GAP * tall))
        low = lowest(filled, gap)
        foot = int(rows[low])
        whole = filled[: low + 1].mean() >= FILLED and low + gap < len(rows)
        if not whole or not self._on(colors, foot) or self._astride(colors, foot, half, gap):
            return None
        return foot

    def go_on(self, rows: Array) -> bool:
        """Whether these rows (R,) show something else in the strip than the floor beside it; not at the lower
        border of the picture, where the rows may be too few.
        """
        if len(rows) < 2 or rows[-1] >= self.pixels.shape[0] - 1:
            return False
        strip = self.axis.beside(rows, max(1, round(WIDTH * self.axis.tall)))
        beside = self._beside(rows, AWAY)
        seen = self._free(beside)
        if self._free(strip).mean() < FREE or seen.mean() < SEEN:
            return False
        colors = self._at(rows, beside)[seen]
        colors = colors[np.linspace(0, len(colors) - 1, COLORS).astype(int)]
        return bool(self._unlike(colors, rows, strip).mean() > UNLIKE)

    def _astride(self, colors: Array, low: int, half: int, gap: int) -> bool:
        """Whether legs leave their strip at its side and go on below its lowest row: it is one of a knee."""
        reach = round(ASTRIDE * self.axis.tall)
        rows = np.arange(max(0, low - gap), min(self.pixels.shape[0], low + 1 + reach))
        columns = self.axis.beside(rows, half + reach)
        strip = slice(0, low + 1 - int(rows[0])), slice(reach, reach + 2 * half + 1)
        return goes_on_below(self._unlike(colors, rows, columns) & self._free(columns), strip, gap)

    def _on(self, colors: Array, low: int) -> bool:
        """Whether the floor goes on above the feet, at both sides of the legs, or at the one that is seen.

        What nearer people hide, or the picture does not show, may be floor as well.
        """
        rows = np.arange(max(0, low - round(ABOVE * self.axis.tall)), low + 1)
        columns = self._beside(rows)
        floor, free = ~self._unlike(colors, rows, columns), self._free(columns)
        sides = zip(np.split(floor, 2, axis=1), np.split(free, 2, axis=1), strict=True)
        seen = [float(side[shown].mean()) for side, shown in sides if shown.mean() >= SEEN]
        return bool(seen) and min(seen) >= GOES_ON

    def _beside(self, rows: Array, reach: tuple[float, float] = (BESIDE, ASIDE)) -> Array:
        """Columns beside the legs at these rows (R,), left ones first, (R, C) px."""
        near, far = (round(k * self.axis.tall) for k in reach)
        away = np.arange(near, far)
        aside = np.concatenate([-away[::-1], away])
        return np.asarray(np.rint(self.axis.column(rows)).astype(int)[:, None] + aside)

    def _unlike(self, colors: Array, rows: Array, columns: Array) -> Array:
        """Which pixels of these rows and columns are unlike the floor of these colours (N, 3)."""
        other = foreground(self._at(rows, columns)[..., None, :], colors, 1.0, SHADOW)
        return np.asarray((~other).mean(axis=-1) < ALIKE)

    def _at(self, rows: Array, columns: Array) -> Array:
        """The pixels of these rows (R,) and columns (R, C), which go on round a panorama."""
        width = self.camera.size[0]
        inside = columns % width if full_turn(self.camera) else np.clip(columns, 0, width - 1)
        return np.asarray(self.pixels[rows[:, None], inside])

    def _free(self, columns: Array) -> Array:
        """Which columns are in the picture, and not of a nearer person."""
        inside = (columns >= 0) & (columns < self.camera.size[0])
        free = np.ones(columns.shape, bool) if full_turn(self.camera) else inside
        for x0, y0, x1, y1 in self.others.tolist():
            free &= np.abs(short_way(columns - (x0 + x1) / 2, turn_of(self.camera))) >= OTHERS * (y1 - y0)
        return free

"""Spheres of a known radius in a depth image.

Each pixel of the foreground is tried as the foremost point of a sphere. Samples within the outline must lie
on the sphere, and most samples around it behind the sphere. What was not measured says nothing, nor does what
lies in front of the sphere and hides it. The best spheres that do not overlap are fitted to all points near
them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from followspot.geometry import depth_rays
from followspot.messages import Array
from followspot.room import Camera
from followspot_balls.depth.sphere_fit import FACE, LEAST, RIM, Fit, fitted

AROUND, ASIDE = 1.15, 0.6
"""Radius of the samples around the outline: over that of the outline, and pixels to add."""
LEAST_ON, LEAST_BEHIND = 0.8, 0.6
"""Smallest share of the samples within the outline that lie on the sphere, and of those around it that lie
behind it; of the samples that say something."""
SMALLEST, LARGEST = 1.5, 80.0
"""Radius of outlines in which spheres are looked for, px."""
APART = 1.2
"""Distance of spheres from each other, over their radius."""


class Spheres(NamedTuple):
    """K spheres."""

    xyz: Array
    """(K, 3) m, centres."""
    pixel: Array
    """(K, 2) px, of the foremost points."""
    area: Array
    """(K,) px that lie on the sphere."""
    face: Array
    """(K,) measured share of the middle of the outline."""
    residual: Array
    """(K,) m, as of `followspot_balls.depth.sphere_fit.Fit`; so is the next."""
    one_sided: Array
    radius: Array
    """(K,) m."""


@dataclass(frozen=True, eq=False)
class Lens:
    """The constants of a depth camera with H x W pixels.

    center: (3,) m; rays: (H, W, 3), of unit depth; stretch: (H, W), their lengths; pitch: (H, W), distance of
    neighbouring rays at unit depth.
    """

    center: Array
    rays: Array
    stretch: Array
    pitch: Array

    @classmethod
    def of(cls, camera: Camera) -> Lens:
        """The lens of a camera; NaN for pixels whose ray does not point forward."""
        rays = depth_rays(camera)
        stretch = np.sqrt(np.vecdot(rays, rays))
        pitch = np.full(stretch.shape, 1.0 / camera.matrix[0, 0])
        if min(stretch.shape) > 1:
            down, right = (np.sqrt(np.vecdot(step, step)) for step in np.gradient(rays, axis=(0, 1)))
            pitch = np.sqrt(down * right)
        return cls(camera.center, rays, stretch, pitch)


def spheres(
    depth: Array, foreground: Array, tried: Array, lens: Lens, radii: Array, tolerance: float
) -> Spheres:
    """The spheres of some radii, (R,) m; those of one radius do not overlap.

    depth: (H, W) m, 0 where nothing was measured; foreground: (H, W) bool; tried: (H, W) bool, the part of it
    in which foremost points are looked for; tolerance: distance of measured points from a sphere, m.
    """
    places = np.nonzero(tried)
    of_each = [_of_radius(depth, foreground, places, lens, radius, tolerance) for radius in radii.tolist()]
    return Spheres(*map(np.concatenate, zip(_collected([], lens, 0.0), *of_each, strict=True)))


def _of_radius(
    depth: Array, foreground: Array, places: tuple[Array, ...], lens: Lens, radius: float, tolerance: float
) -> Spheres:
    """The spheres of one radius; places: rows and columns of the pixels that are tried."""
    row, column = places
    outline = radius / (lens.pitch[row, column] * depth[row, column])
    rows = ((outline >= SMALLEST) & (outline <= LARGEST)).nonzero()[0]
    place = Place(row[rows], column[rows], outline[rows])
    middle = depth[place.row, place.column] + radius / lens.stretch[place.row, place.column]
    behind = _share_behind(depth, place, middle)
    rows = (behind >= LEAST_BEHIND).nonzero()[0]
    place, middle, behind = Place(*(a[rows] for a in place)), middle[rows], behind[rows]
    center = middle[:, None] * lens.rays[place.row, place.column]
    on, share = _on_sphere(depth, lens, place, center, radius, tolerance)
    possible = (share >= LEAST_ON) & (on >= LEAST)
    found = []
    for k in _apart(center, on * share * behind * possible, APART * radius):
        spot = int(place.row[k]), int(place.column[k])
        fit = _fit(depth, foreground, lens, spot, float(place.outline[k]), center[k], radius, tolerance)
        if fit is not None:
            found.append((spot, fit))
    return _collected(found, lens, radius)


class Place(NamedTuple):
    """N foremost points."""

    row: Array
    """(N,) int."""
    column: Array
    """(N,) int."""
    outline: Array
    """(N,) px, radius of the sphere's outline there."""


def _circle(radius: float, count: int) -> Array:
    """Points on a circle, (count, 2)."""
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


WITHIN = np.concatenate([_circle(0.0, 1), _circle(0.35, 5), _circle(0.7, 9)])
"""Samples within the outline, over its radius."""
CIRCLE = _circle(1.0, 12)


def _samples(shape: tuple[int, ...], place: Place, offset: Array) -> Array:
    """Flat indices of the pixels at offsets (N, S, 2) px; the border stands for what is beyond it: (N, S)."""
    x = np.rint(place.column[:, None] + offset[..., 0]).astype(np.intp)
    y = np.rint(place.row[:, None] + offset[..., 1]).astype(np.intp)
    return np.asarray(np.clip(y, 0, shape[0] - 1) * shape[1] + np.clip(x, 0, shape[1] - 1))


def _share_behind(depth: Array, place: Place, middle: Array) -> Array:
    """Share of the samples around the outlines that lie behind the centres: (N,); middle: (N,) m, depths."""
    offset = (AROUND * place.outline + ASIDE)[:, None, None] * CIRCLE
    sampled = depth.reshape(-1).take(_samples(depth.shape, place, offset))
    behind = np.count_nonzero(sampled > middle[:, None], axis=1)
    return np.asarray(behind / np.maximum(np.count_nonzero(sampled > 0, axis=1), 1))


def _on_sphere(
    depth: Array, lens: Lens, place: Place, center: Array, radius: float, tolerance: float
) -> tuple[Array, Array]:
    """Number of samples within the outlines that lie on the spheres, and share of those on or behind them.

    center: (N, 3) m, from the camera. Returns (N,) each.
    """
    index = _samples(depth.shape, place, place.outline[:, None, None] * WITHIN)
    z = depth.reshape(-1).take(index)
    offset = lens.rays.reshape(-1, 3).take(index, axis=0) * z[..., None] - center[:, None]
    away = np.sqrt(np.vecdot(offset, offset)) - radius
    on = np.count_nonzero((np.abs(away) <= tolerance) & (z > 0), axis=1)
    behind = np.count_nonzero((away > tolerance) & (np.vecdot(offset, center[:, None]) > 0), axis=1)
    return np.asarray(on), np.asarray(on / np.maximum(on + behind, 1))


def _apart(center: Array, score: Array, distance: float) -> list[int]:
    """Rows of positive score from the best on, none nearer than a distance (m) to a better one.

    center: (N, 3) m; score: (N,).
    """
    left, chosen = score.copy(), []
    while len(left) and left.max() > 0:
        best = int(left.argmax())
        chosen.append(best)
        offset = center - center[best]
        left[np.vecdot(offset, offset) < distance * distance] = 0
        left[best] = 0
    return chosen


def _fit(
    depth: Array,
    foreground: Array,
    lens: Lens,
    spot: tuple[int, int],
    outline: float,
    center: Array,
    radius: float,
    tolerance: float,
) -> Fit | None:
    """The sphere fitted to the points around its foremost one; spot: row and column; outline: px."""
    reach = int(outline * RIM[1]) + 1
    window = tuple(slice(max(middle - reach, 0), middle + reach + 1) for middle in spot)
    z = depth[window]
    there = z > 0
    points = lens.rays[window][there] * z[there, None]
    return fitted(points, foreground[window][there], center, radius, tolerance)


def _collected(found: list[tuple[tuple[int, int], Fit]], lens: Lens, radius: float) -> Spheres:
    """Spheres from their spots and fits."""
    spot = np.array([spot for spot, _ in found], int).reshape(-1, 2)
    center = np.array([fit.center for _, fit in found]).reshape(-1, 3)
    outline = radius * lens.stretch[spot[:, 0], spot[:, 1]] / lens.pitch[spot[:, 0], spot[:, 1]]
    outline /= np.sqrt(np.vecdot(center, center))
    points, face, residual, one_sided = np.array([fit[1:] for _, fit in found], float).reshape(-1, 4).T
    return Spheres(
        xyz=lens.center + center,
        pixel=spot[:, ::-1].astype(float),
        area=points,
        face=face / (np.pi * np.square(FACE * outline)),
        residual=residual,
        one_sided=one_sided,
        radius=np.full(len(spot), radius),
    )

"""Ray casting among capsules: occlusion between a camera and a ball.

A capsule is all points within `radius` of a segment; a ball is a capsule whose segment is a point.
Functions broadcast over leading axes, so that one call serves many cameras, balls and limbs. They
multiply and add one coordinate after the other: the result of a ray does not depend on the others, to the
last bit.
"""

from __future__ import annotations

import numpy as np

from followspot import Array


def dot(a: Array, b: Array) -> Array:
    """Scalar products of vectors (..., 3)."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def unit(v: Array) -> tuple[Array, Array]:
    """Directions (..., 3) and lengths (...) of vectors."""
    length = np.sqrt(dot(v, v))
    return v / length[..., None], length


def closest_approach(origin: Array, rays: Array, ends: Array) -> tuple[Array, Array]:
    """How near rays come to segments, (...) m, and how far along the ray that is, (...) m.

    origin: (..., 3) m; rays: (..., 3), unit vectors; ends: (..., 2, 3) m.
    """
    start, axis = ends[..., 0, :] - origin, ends[..., 1, :] - ends[..., 0, :]
    along_axis, along_start = dot(axis, rays), dot(start, rays)
    across = np.maximum(dot(axis, axis) - along_axis * along_axis, 1e-12)
    both = dot(axis, start) - along_start * along_axis
    t = np.minimum(np.maximum(-both / across, 0.0), 1.0)
    square = dot(start, start) - along_start * along_start + t * (2 * both + t * across)
    return np.sqrt(np.maximum(square, 0.0)), along_start + t * along_axis


def half_chord(radius: Array, miss: Array) -> Array:
    """Half the chord of a ray through a ball or across a capsule that it passes at `miss`, m; 0 outside."""
    return np.asarray(np.sqrt(np.maximum(radius * radius - miss * miss, 0.0)))


def sunflower_disc(samples: int) -> Array:
    """Points that fill the unit disc evenly, as the seeds of a sunflower do: (samples, 2)."""
    k = np.arange(samples) + 0.5
    radius, angle = np.sqrt(k / samples), np.pi * (1 + np.sqrt(5)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def first_hit(origin: Array, rays: Array, ends: Array, radius: float) -> Array:
    """Exact first intersections of rays with a capsule: (...) m along the ray, infinite if they miss.

    origin: (3,) m, outside the capsule; rays: (..., 3), unit vectors; ends: (2, 3) m.
    """
    nearest = np.full(rays.shape[:-1], np.inf)
    axis = ends[1] - ends[0]
    length2 = float(dot(axis, axis))
    for end in ends if length2 > 0 else ends[:1]:
        away = end - origin
        along = dot(rays, away)
        inside = along * along - float(dot(away, away)) + radius * radius
        reach = along - np.sqrt(np.maximum(inside, 0.0))
        np.minimum(nearest, np.where((inside >= 0) & (reach > 0), reach, np.inf), out=nearest)
    if length2 > 0:
        start = origin - ends[0]
        up, rise = dot(rays, axis), float(dot(start, axis))
        a = np.maximum(length2 - up * up, 1e-12)
        b = length2 * dot(rays, start) - rise * up
        c = length2 * (float(dot(start, start)) - radius * radius) - rise * rise
        inside = b * b - a * c
        reach = (-b - np.sqrt(np.maximum(inside, 0.0))) / a
        height = rise + reach * up
        hit = (inside >= 0) & (reach > 0) & (height > 0) & (height < length2)
        np.minimum(nearest, np.where(hit, reach, np.inf), out=nearest)
    return nearest

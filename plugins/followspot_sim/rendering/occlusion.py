"""Occlusion of balls by people in a picture."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_sim.rendering.ball_image import Stamps
from followspot_sim.rendering.camera_rays import CameraRays
from followspot_sim.rendering.ray_casting import closest_approach, half_chord, unit

SOFT = 1.3
"""Radius of a ball with its soft edge, over its own."""


def hide(seen: Stamps, view: CameraRays, places: Array, ends: Array, thick: Array) -> None:
    """Remove what limbs hide from the cover of the balls, and compute the visible shares.

    A ball in a hand or half in a bag is partly before a limb and partly in it or behind it, so the surfaces
    are compared on the line of sight of each pixel, as the truth does. The edge of a limb is a pixel wide.

    places: (B, 4) centres and radii of the balls, m; ends: (K, 2, 3) m and thick: (K,) m, the limbs.
    """
    rays, distance = unit(places[:, :3] - view.camera.center)
    gap, along = closest_approach(view.camera.center, rays[:, None], ends)
    radius, distance = places[:, 3:], distance[:, None]
    ball, limb = ((gap < thick + SOFT * radius) & (along - thick < distance + radius)).nonzero()
    if len(ball) == 0:
        return
    whole = seen.cover.sum(axis=(1, 2))
    left = 1 - _hidden(seen, view, places, ball, ends[limb], thick[limb])
    first = np.flatnonzero(np.diff(ball, prepend=-1))
    kept = np.multiply.reduceat(left, first, axis=0)
    seen.cover[ball[first]] = np.rint(kept * seen.cover[ball[first]])
    np.divide(seen.cover.sum(axis=(1, 2)), np.maximum(whole, 1), out=seen.shown)


def _hidden(seen: Stamps, view: CameraRays, places: Array, ball: Array, ends: Array, thick: Array) -> Array:
    """Share of each pixel of a ball's window that a limb hides, (N, S, S); 0 where the ball is not.

    ball: (N,) their rows; ends: (N, 2, 3) m; thick: (N,) m.
    """
    hidden = np.zeros((len(ball), *seen.cover.shape[1:]))
    pair, y, x = seen.cover[ball].nonzero()
    ball, thick = ball[pair], thick[pair]
    column, row = seen.corner[ball].T
    pixel = (row + y) * view.camera.size[0] + column + x
    gap, along = closest_approach(view.camera.center, view.rays.take(pixel, axis=1).T, ends[pair])
    radius = places[ball, 3]
    miss2 = seen.square[ball, y, x] * radius**2
    face = np.sqrt(seen.distance[ball] ** 2 - miss2) - np.sqrt(np.maximum(radius**2 - miss2, 0))
    covered = (thick - gap) / (view.pitch[pixel] * along) + 0.5
    hidden[pair, y, x] = np.minimum(np.maximum(covered, 0), 1) * (along - half_chord(thick, gap) < face)
    return hidden

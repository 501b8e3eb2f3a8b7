"""Precision of a blob's centre from its area: partly hidden, whole, or merged with other light."""

from __future__ import annotations

import numpy as np

from followspot.geometry import back_projection
from followspot.messages import Array
from followspot.room import Room
from followspot_balls.measurement.outline import unit_outline

WHOLE = 1.2
"""Largest area over the outline's of an unmerged blob; a larger blob includes other light."""


class Outlines:
    """The share of a target's outline that each blob shows, from its area and the target's depth."""

    def __init__(self, room: Room) -> None:
        cameras = list(room.cameras.values())
        self.back = np.array([back_projection(c) for c in cameras]).reshape(-1, 3, 3)
        self.unit = unit_outline(room)

    def at_unit_depth(self, xy: Array, area: Array) -> Array:
        """Blobs' sizes over those of balls of unit radius at unit depth: (C, K, 2), (C, K) px -> (C, K).

        Times the squared depth over the squared radius it is the share of the outline. A sphere looks
        as large as its distance makes it, which towards the border of a picture exceeds its depth.
        """
        rays = xy @ self.back[:, :, :2].swapaxes(1, 2) + self.back[:, None, :, 2]
        return np.asarray(area * np.square(rays).sum(axis=2) / self.unit[:, None])


def variance(share: Array, sigma: float, hidden: float, merged: float) -> Array:
    """Variance of a centre along each axis, px^2, by the share of the outline that the blob shows.

    sigma: of a whole ball, px; hidden: sigmas that it grows by for an outline that is missing; merged:
    likewise for the squared excess of a blob that is larger.
    """
    growth = hidden * np.maximum(1.0 - share, 0.0) + merged * np.square(np.maximum(share - WHOLE, 0.0))
    return np.asarray(sigma * sigma * (1.0 + growth * growth))

"""How exact a blob's centre is, as its size tells: hidden in part, whole, or merged with other light."""

from __future__ import annotations

import numpy as np

from followspot.geometry import back_projection
from followspot.messages import Array
from followspot.room import Room

WHOLE = 1.2
"""Largest share of its outline that a blob alone shows; more is light of something else."""


class Outlines:
    """What part of a target's outline each blob shows, by its size and the target's depth."""

    def __init__(self, room: Room) -> None:
        cameras = list(room.cameras.values())
        self.back = np.array([back_projection(c) for c in cameras]).reshape(-1, 3, 3)
        focal = np.array([c.matrix[0, 0] for c in cameras])
        self.unit = np.pi * np.square(focal) * bright_part(room, focal)

    def at_unit_depth(self, xy: Array, area: Array) -> Array:
        """Blobs' sizes over those of balls of unit radius at unit depth: (C, K, 2), (C, K) px -> (C, K).

        Times the squared depth over the squared radius it is the share of the outline. A sphere looks
        as large as its distance makes it, which towards the border of a picture exceeds its depth.
        """
        rays = xy @ self.back[:, :, :2].swapaxes(1, 2) + self.back[:, None, :, 2]
        return np.asarray(area * np.square(rays).sum(axis=2) / self.unit[:, None])


def bright_part(room: Room, focal: Array) -> Array:
    """Part of a whole ball's outline that its blob fills in each camera: (C,), 1 where it was not learnt.

    Reflective patches are dim towards the rim, so an infrared blob may show less of a ball than a
    colour blob. The templates tell how large whole balls are, for cameras about equally far away.
    """
    sizes = np.full(len(focal), np.nan)
    for number, name in enumerate(room.cameras):
        learnt = [np.sqrt(t.area[name][0] * t.area[name][1]) for t in room.targets.values() if name in t.area]
        if learnt:
            sizes[number] = np.median(learnt) / focal[number] ** 2
    color = sizes[[c.kind == "color" for c in room.cameras.values()]]
    known = color[color > 0]
    share = sizes / np.median(known) if len(known) else np.ones(len(sizes))
    return np.where(share > 0, share, 1.0)


def variance(share: Array, sigma: float, hidden: float, merged: float) -> Array:
    """Variance of a centre along each axis, px^2, by the share of the outline that the blob shows.

    sigma: of a whole ball, px; hidden: sigmas that it grows by for an outline that is missing; merged:
    likewise for the squared excess of a blob that is larger.
    """
    growth = hidden * np.maximum(1.0 - share, 0.0) + merged * np.square(np.maximum(share - WHOLE, 0.0))
    return np.asarray(sigma * sigma * (1.0 + growth * growth))

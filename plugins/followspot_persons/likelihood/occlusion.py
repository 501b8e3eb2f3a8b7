"""Occlusion: nearer people hide features of farther ones."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from followspot import Array
from followspot_persons.body.shape import ShapeModel
from followspot_persons.body.view import view
from followspot_persons.likelihood.fitness import Picture
from followspot_persons.panorama import full_turn

SUBPIXEL = 4
"""Binary digits of a pixel's fraction in a polygon."""


def covered(picture: Picture, shape: ShapeModel, pose: Array) -> Picture:
    """The picture in which a person of this shape and pose (6,) hides people farther away."""
    camera = picture.camera
    width, height = camera.size
    hidden = np.zeros(width * height, np.uint8) if picture.hidden is None else picture.hidden.copy()
    outline = silhouette(shape, view(camera, shape, pose[None]).edge[0], float(height))
    if np.isfinite(outline).all():
        mask = hidden.reshape(height, width)
        for shift in (-width, 0, width) if full_turn(camera) else (0,):
            moved = np.clip(outline + np.array([shift, 0]), -4 * width, 4 * width)
            points = np.rint(moved * (1 << SUBPIXEL)).astype(np.int32)
            cv2.fillPoly(mask, [points], 1, shift=SUBPIXEL)
    return replace(picture, hidden=hidden)


def silhouette(shape: ShapeModel, edge: Array, bottom: float) -> Array:
    """The outline of one body as a polygon (N, 2) px, from the left foot over the crown to the right one.

    edge: (E, 2) px of a view; bottom: row to which the body goes on below its last section.
    """
    side = shape.outline.side
    left, crown, right = (edge[side == s][np.argsort(-shape.outline.up[side == s])] for s in (-1, 0, 1))
    feet = np.array([[left[-1, 0], bottom], [right[-1, 0], bottom]])
    return np.concatenate([feet[:1], left[::-1], crown, right, feet[1:]])


@dataclass(frozen=True, eq=False)
class Shades:
    """A picture in which nearer people hide farther ones: for those with a number, and for tentative ones.

    Who is tentative may be no person, and hides nobody with a number.
    """

    numbered: Picture
    tentative: Picture

    def of(self, number: int) -> Picture:
        """The picture of a person; number: 0 for a tentative one."""
        return self.numbered if number else self.tentative

    def behind(self, number: int, shape: ShapeModel, pose: Array) -> Shades:
        """With one more person of this shape and pose (6,)."""
        numbered = covered(self.numbered, shape, pose) if number else self.numbered
        return Shades(numbered, covered(self.tentative, shape, pose))

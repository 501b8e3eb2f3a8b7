"""How much of each actor's upper body a camera sees."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_sim.actor.backdrop import backdrop
from followspot_sim.actor.body import Body
from followspot_sim.actor.paint import FARTHEST, in_picture, patches, unwrapped
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.scene import Play, stage_of
from followspot_sim.rendering.outline import SUBPIXEL

COARSE = 4
"""Factor by which the pictures in which shares are counted are smaller, in width and height."""


class VisibilityOfActors:
    """Visible shares of actors in one camera."""

    def __init__(self, params: ActorParams, camera: Camera) -> None:
        self._cast = stage_of(params).cast
        self._camera = coarser(camera, COARSE)
        self._away = backdrop(params, self._camera).away

    def visible(self, play: Play) -> Array:
        """Visible share of each upper body, (P,): of the area that faces the camera.

        The picture's edge, furniture and other people hide it; the person's own arms do not.
        """
        center = self._camera.center[:2]
        level = np.array([np.hypot(*(center - (s.x, s.y))) for s in play.stances])
        hidden = np.zeros(self._away.shape, np.uint8)
        shares = np.zeros(len(level))
        for person in np.argsort(level, kind="stable").tolist():
            body, surface = self._cast[person].body, play.surfaces[person]
            shares[person] = self._share(body, surface, (hidden > 0) | (self._away < level[person]))
            for outline in self._silhouette(body, surface):
                cv2.fillConvexPoly(hidden, outline, 1)
        return shares

    def _share(self, body: Body, surface: Array, hidden: Array) -> float:
        seen = patches(self._camera, surface, body.mesh.face)
        upper = body.upper[seen.face]
        polygon = seen.polygon[upper] / (1 << SUBPIXEL)
        (ax, ay), (bx, by) = (polygon[:, 2] - polygon[:, 0]).T, (polygon[:, 3] - polygon[:, 1]).T
        area = np.abs(ax * by - ay * bx) / 2
        height, width = hidden.shape
        shown = 0.0
        for place in in_picture(self._camera, seen):
            x, y = np.rint(place.polygon[upper].mean(axis=1) / (1 << SUBPIXEL)).astype(int).T
            inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
            shown += float(area[inside][~hidden[y[inside], x[inside]]].sum())
        return min(shown / float(area.sum()), 1.0) if shown else 0.0

    def _silhouette(self, body: Body, surface: Array) -> list[Array]:
        """Outlines of the parts of a body, each convex, wherever they are in the picture."""
        pixel = project(self._camera, surface)
        if not (np.abs(pixel) < FARTHEST).all():
            return []
        panorama = self._camera.model == "cylinder"
        turn = 2 * np.pi * self._camera.matrix[0, 0]
        found = []
        for bone in np.unique(body.mesh.bone[:, 0]):
            part = pixel[body.mesh.bone[:, 0] == bone]
            if panorama:
                part[:, 0] = unwrapped(self._camera, part[:, 0])
            hull = cv2.convexHull(part.astype(np.float32))[:, 0]
            shifts = np.array([[-turn, 0], [0, 0], [turn, 0]] if panorama else [[0, 0]])
            found.extend(np.rint(hull + shifts[:, None]).astype(np.int32))
        return found


def coarser(camera: Camera, times: int) -> Camera:
    """The same camera with pixels `times` as wide and high."""
    width, height = (-(-side // times) for side in camera.size)
    matrix = camera.matrix / times
    matrix[:2, 2] = (camera.matrix[:2, 2] + 0.5) / times - 0.5
    matrix[2, 2] = 1.0
    return replace(camera, size=(width, height), matrix=matrix)

"""The people of the slow instance, projected into the picture of a camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot_persons.body.shape import ShapeModel
from followspot_persons.body.view import view
from followspot_persons.box_geometry import on_body
from followspot_persons.panorama import turn_of
from followspot_persons.slow_instance.known_person import KnownPerson

PART = 0.8
"""Height of a box over that of the upper body below which it shows a part of it."""


@dataclass(frozen=True, eq=False)
class ProjectedBodies:
    """Of one camera, with the shape model."""

    camera: Camera
    shape: ShapeModel

    def boxes(self, people: Sequence[KnownPerson]) -> Array:
        """Upper bodies of people, (K, 4) px."""
        poses = np.array([p.track.pose for p in people]).reshape(-1, 6)
        return view(self.camera, self.shape, poses).box

    def distance(self, person: KnownPerson) -> float:
        """Distance of a person from the camera, m."""
        return float(np.hypot(*(person.track.pose[:2] - self.camera.center[:2])))

    def nearer(self, people: Sequence[KnownPerson], person: KnownPerson) -> Array:
        """Upper bodies of numbered people who are nearer than a person, (K, 4) px."""
        away = self.distance(person)
        return self.boxes([p for p in people if p.number and self.distance(p) < away])

    def parts(self, boxes: Array, people: Sequence[KnownPerson]) -> Array:
        """Which boxes (N, 4) px are parts of one of these bodies, as a head or a hip: (N,) bool."""
        found, turn = np.zeros(len(boxes), bool), turn_of(self.camera)
        for body in self.boxes(people):
            smaller = boxes[:, 3] - boxes[:, 1] < PART * (body[3] - body[1])
            found |= smaller & on_body(boxes, body[None], turn)
        return found

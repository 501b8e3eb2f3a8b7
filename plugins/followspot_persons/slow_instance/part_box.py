"""Boxes of a head or a chest alone, where feet are seen much nearer: the whole upper body instead."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project, ray
from followspot_persons.background.floor_beside import contact_beside
from followspot_persons.background.floor_contact import LARGEST_CHANGE, Contact, presence
from followspot_persons.background.scene import Scene
from followspot_persons.body.standing import WAIST, knows_floor, standing
from followspot_persons.body.upper_body_box import RATIO
from followspot_persons.likelihood.fitness import Detection

SIZE = 0.1
"""Sigma of a distance by the size of a sure box, relative."""


@dataclass(frozen=True, eq=False)
class Stood:
    """A detection beside the floor.

    detection: with the box of the whole upper body; part: whether its box was of a part; contact: where the
    person stands, None if the feet are not seen.
    """

    detection: Detection
    part: bool = False
    contact: Contact | None = None


def stood(
    camera: Camera,
    pixels: Array,
    scene: Scene | None,
    detection: Detection,
    pose: Array,
    stature: float,
    others: Array,
) -> Stood:
    """A detection of a person about a pose (6,), of a height, m. others: of :func:`presence`.

    Feet that the background does not tell, because it is not known yet or shows a ghost, the floor about them
    may. pixels: (H, W, 3) u1 BGR.
    """
    if not knows_floor(camera):
        return Stood(detection)
    there = turned(camera, pose, detection.box)
    shown = presence(scene, there, others)
    contact = None if shown is None else shown.contact
    contact = contact or contact_beside(camera, pixels, there, others)
    if contact is None:
        return Stood(detection)
    by_size = float(standing(camera, detection.box[None])[0][0])
    if by_size <= contact.distance / (1 - LARGEST_CHANGE):
        return Stood(detection, contact=contact)
    return Stood(replace(detection, box=whole(camera, there, contact, stature)), part=True, contact=contact)


def by_size(camera: Camera, detection: Detection) -> Contact | None:
    """Where the size of a box says that a person stands; None if it says nothing."""
    distance = float(standing(camera, detection.box[None])[0][0])
    if detection.certainty == 0 or not np.isfinite(distance):
        return None
    return Contact(distance, SIZE * distance / detection.certainty)


def turned(camera: Camera, pose: Array, box: Array) -> Array:
    """The pose at the same distance in the direction of a box."""
    direction = ray(camera, np.array([[(box[0] + box[2]) / 2, box[1]]]))[0, :2]
    away = np.hypot(*(pose[:2] - camera.center[:2]))
    return np.concatenate([camera.center[:2] + away * direction / np.hypot(*direction), pose[2:]])


def whole(camera: Camera, pose: Array, contact: Contact, stature: float) -> Array:
    """Box (4,) px of the upper body of a person in the direction of a pose, at the distance of the contact.

    pose: (6,); stature: m.
    """
    return _box(camera, pose[:2] - camera.center[:2], contact.distance, stature)


def upper_body(camera: Camera, top: Array, distance: float, stature: float) -> Array:
    """Box (4,) px of the upper body of a person; top: (2,) px, the head's; distance, stature: m."""
    return _box(camera, ray(camera, top[None])[0, :2], distance, stature)


def _box(camera: Camera, to: Array, distance: float, stature: float) -> Array:
    """Box (4,) px of the upper body of a person in a horizontal direction. to: (2,); others: m."""
    place = camera.center[:2] + to * distance / np.hypot(*to)
    head, waist = project(camera, np.array([[*place, stature], [*place, WAIST * stature]]))
    half = RATIO / 2 * (waist[1] - head[1])
    return np.array([head[0] - half, head[1], head[0] + half, waist[1]])

"""Finds people whom the detector misses: foreground that stands on the floor and has the size of a person.

The feet give the distance, and with it the height of the head's top. If the feet are below the picture, the
usual height of people gives the distance. A region as high and as broad as a person may be a person, unless
it is a ghost. A door that was opened does not move; people who stand still sway.
"""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array
from followspot.people import Boxes
from followspot_persons.background.background import foreground
from followspot_persons.background.body_axis import BEFORE_AXIS
from followspot_persons.background.existence import RIGID
from followspot_persons.background.ghost import is_ghost
from followspot_persons.background.scene import Scene
from followspot_persons.body.standing import knows_floor, rise
from followspot_persons.body.stature import USUAL
from followspot_persons.box_geometry import on_body
from followspot_persons.panorama import turn_of
from followspot_persons.slow_instance.foreground_box import LEVEL, STEP
from followspot_persons.slow_instance.part_box import upper_body

SHORTEST, TALLEST = 1.45, 2.05
"""Heights of grown people, m."""
SLENDER, BROAD = 0.25, 0.8
"""Mean width of an upper body, over its height."""
SMALLEST = 40
"""Smallest height of the visible part of a person, px."""
BORDER = 2 * STEP
"""Distance from the picture's upper and lower border at which head and feet are seen, px."""
SCORE = 1.0
"""Score of a person whom the detector misses: that of a weak box."""
HEAD = 0.12
"""Share of the height in which the head's top is searched for."""


def completed(boxes: Boxes, scene: Scene, mask: Array, before: Array) -> Boxes:
    """A detector's boxes, and those of people whom it misses. mask, before: of :func:`foreground_people`."""
    found = foreground_people(scene, mask, before)
    found = found[~on_body(found, boxes.box, turn_of(scene.camera))]
    none = np.zeros((len(found), boxes.torso.shape[1]))
    return Boxes(
        camera=boxes.camera,
        box=np.concatenate([boxes.box, found]),
        score=np.concatenate([boxes.score, np.full(len(found), SCORE)]),
        torso=np.concatenate([boxes.torso, none]),
        head=np.concatenate([boxes.head, none]),
    )


def foreground_people(scene: Scene, mask: Array, before: Array) -> Array:
    """Upper bodies of regions that look like standing people, (N, 4) px.

    mask: (H / STEP, W / STEP) bool, foreground; before: (H, W, 3) u1, the last picture.
    """
    if not knows_floor(scene.camera):
        return np.empty((0, 4))
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 3), np.uint8))
    _, label, stats, _ = cv2.connectedComponentsWithStats(closed)
    rows = stats[:, [cv2.CC_STAT_TOP, cv2.CC_STAT_HEIGHT]]
    parts = [(label == i, int(top), int(height)) for i, (top, height) in enumerate(rows.tolist()) if i]
    large = [part for part in parts if part[2] * STEP >= SMALLEST and _moves(scene, part[0], before)]
    boxes = [_standing(scene, *part) for part in large]
    return np.array([box for box in boxes if box is not None]).reshape(-1, 4)


def _standing(scene: Scene, part: Array, first: int, height: int) -> Array | None:
    """The upper body, (4,) px, if a part of a mask is a person; first: its first row."""
    camera, top, low = scene.camera, first * STEP, (first + height) * STEP
    now, then = scene.pixels[::STEP, ::STEP], scene.background[::STEP, ::STEP]
    if top < BORDER or is_ghost(part, now, then, scene.light):
        return None
    column = (
        float(np.flatnonzero(part[first : first + max(1, round(HEAD * height))].any(axis=0)).mean()) * STEP
    )
    up, down = rise(camera, np.array([column, column]), np.array([top, low - 0.5]))
    eye, stature = camera.center[2], USUAL
    if low <= camera.size[1] - BORDER:
        distance = -eye / down + BEFORE_AXIS if down < 0 else 0.0
        stature = eye + up * distance
    else:
        distance = (stature - eye) / up if abs(stature - eye) >= LEVEL and up * (stature - eye) > 0 else 0.0
    if distance <= 0 or not SHORTEST <= stature <= TALLEST:
        return None
    box = upper_body(camera, np.array([column, top]), float(distance), float(stature))
    tall = box[3] - box[1]
    body = part[first : first + max(1, round(tall / STEP))]
    return box if SLENDER <= body.sum(axis=1).mean() * STEP / tall <= BROAD else None


def _moves(scene: Scene, part: Array, before: Array) -> bool:
    """Whether a part, or its outline, has changed since the last picture."""
    if before.shape != scene.pixels.shape:
        return False
    about = cv2.dilate(part.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    now, then = (pixels[::STEP, ::STEP][about] for pixels in (scene.pixels, before))
    return bool(foreground(now, then, 1.0).mean() >= RIGID)

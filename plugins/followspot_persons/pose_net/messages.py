"""What a network has found in a picture, as messages: joints, and boxes of upper bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array, Camera
from followspot.geometry import undistort
from followspot.people import Boxes
from followspot.points import Points2D
from followspot_persons.body.upper_body_box import upper_bodies
from followspot_persons.pose_net.contract import People
from followspot_persons.pose_net.joint_headings import headings

SURE = 0.99
"""Largest probability whose log-odds count."""


def points_of(people: People, joints: Sequence[str], camera: Camera, minimum: float, turn: int) -> Points2D:
    """The joints whose certainty is at least `minimum`. turn: columns of a full turn, 0 for none."""
    instance, joint = np.nonzero(people.certainty >= minimum)
    pixel = people.pixel[instance, joint]
    if turn:
        pixel[:, 0] -= turn * np.floor((pixel[:, 0] + 0.5) / turn)
    return Points2D(
        camera=camera.name,
        labels=tuple(joints),
        label=joint.astype(np.int32),
        instance=instance.astype(np.int32),
        pixel=pixel,
        xy=undistort(camera, pixel),
        score=people.certainty[instance, joint],
    )


def boxes_of(
    people: People, joints: Sequence[str], camera: str, minimum: float, threshold: float, turn: int
) -> Boxes:
    """The upper bodies with their directions; their scores are log-odds above those of the threshold.

    minimum: certainty of joints that count; threshold: score of a person at which a box's score is 0.
    """
    weight = np.where(people.certainty >= minimum, people.certainty, 0.0)
    box = upper_bodies(joints, people.pixel, weight)
    rows = np.flatnonzero(np.isfinite(box).all(axis=1))
    box = box[rows]
    if turn:
        box[:, ::2] -= turn * np.floor((box[:, :1] + 0.5) / turn)
    odds = _log_odds(people.score[rows]) - _log_odds(np.array(threshold))
    torso, head = headings(joints, people.pixel[rows], weight[rows] > 0, box[:, 3] - box[:, 1])
    return Boxes(camera=camera, box=box, score=odds, torso=torso, head=head)


def _log_odds(share: Array) -> Array:
    bounded = np.clip(share, 1 - SURE, SURE)
    return np.asarray(np.log(bounded / (1 - bounded)))

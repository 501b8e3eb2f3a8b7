"""Directions of chest and face from joints, against people who are put into a room and projected."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.drawn import perspective, standing

from followspot.geometry import project, wrap
from followspot_persons.body.standing import WAIST
from followspot_persons.body.upper_body_box import LEVELS
from followspot_persons.body.view import bearing
from followspot_persons.hog.model import DIRECTIONS
from followspot_persons.pose_net.joint_headings import headings
from followspot_persons.pose_net.movenet import COCO

ANGLES = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
SIDES = {"shoulder": 0.19, "hip": 0.12, "ear": 0.068, "eye": 0.03}
"""Half the distance of left and right, m."""
AHEAD = {"nose": 0.1, "shoulder": -0.04}
"""How far joints lie before the body's axis, m."""
CAMERA = perspective()


def projected(pose: np.ndarray) -> tuple[np.ndarray, float]:
    """Joints (17, 2) px of a body with this pose (6,), and the height of its upper body, px."""
    x, y, height, heading, pan, _ = pose
    points = []
    for name in COCO:
        side, _, part = name.rpartition("_")
        own = heading + pan if part in ("nose", "eye", "ear") else heading
        forward, left = np.array([np.cos(own), np.sin(own)]), np.array([-np.sin(own), np.cos(own)])
        sign = {"left": 1, "right": -1}.get(side, 0)
        place = [x, y] + sign * SIDES.get(part, 0) * left + AHEAD.get(part, 0.0) * forward
        points.append([*place, LEVELS.get(part, 0.3) * height])
    top, low = project(CAMERA, np.array([[x, y, height], [x, y, WAIST * height]]))[:, 1]
    return project(CAMERA, np.array(points)), low - top


def told(pose: np.ndarray, *parts: str) -> tuple[np.ndarray, np.ndarray]:
    pixel, height = projected(pose)
    found = np.array([[name.endswith(parts) for name in COCO]])
    torso, head = headings(COCO, pixel[None], found, np.array([height]))
    return torso[0], head[0]


ALL = ("nose", "ear", "shoulder", "hip")


@pytest.mark.parametrize("heading", np.arange(0, 2 * np.pi, np.pi / 6))
@pytest.mark.parametrize("pan", [-0.5, 0.0, 0.5])
def test_chest_and_face_point_where_the_body_in_the_room_does(heading, pan):
    pose = standing(3.0, 0.4, heading=heading)
    pose[4] = pan
    truth = bearing(CAMERA, pose[None])
    torso, head = told(pose, *ALL)
    assert abs(wrap(ANGLES[torso.argmax()] - truth.torso[0])) < np.radians(30)
    assert abs(wrap(ANGLES[head.argmax()] - truth.head[0])) < np.radians(30)


def test_shoulders_alone_leave_open_to_which_side_a_chest_is_turned():
    torso, head = told(standing(3.0, heading=np.pi + 1.0), "shoulder")
    mirrored = torso[-np.arange(DIRECTIONS) % DIRECTIONS]
    assert torso == pytest.approx(mirrored)
    assert abs(wrap(ANGLES[torso.argmax()])) == pytest.approx(1.0, abs=0.25)
    assert np.ptp(head) < np.ptp(torso)


def test_a_face_tells_the_side_to_which_a_chest_is_turned():
    torso, _ = told(standing(3.0, heading=np.pi + 1.2), *ALL)
    ahead, mirrored = torso[3], torso[-3]
    assert ahead > mirrored + 1


def test_a_chest_whose_joints_were_not_found_is_where_the_neck_allows_it():
    torso, head = told(standing(3.0, heading=np.pi + 1.0), "nose", "ear")
    assert head.argmax() == torso.argmax()
    assert torso.max() > torso[torso.argmax() - 8] + 1
    assert np.ptp(torso) < np.ptp(told(standing(3.0, heading=np.pi + 1.0), *ALL)[0])


def test_without_joints_every_direction_is_as_likely_and_all_are_probabilities():
    for parts in ((), ("wrist",), ALL):
        for table in told(standing(3.0, heading=2.0), *parts):
            assert np.exp(table).sum() == pytest.approx(1)
    assert np.ptp(told(standing(3.0), "wrist")[0]) == pytest.approx(0)
    torso, head = headings(("left_wrist",), np.zeros((2, 1, 2)), np.ones((2, 1), bool), np.ones(2))
    assert torso == pytest.approx(np.log(1 / DIRECTIONS))
    assert head.shape == (2, DIRECTIONS)
    nobody, _ = headings(COCO, np.zeros((0, 17, 2)), np.zeros((0, 17), bool), np.zeros(0))
    assert nobody.shape == (0, DIRECTIONS)


def test_no_direction_is_impossible():
    assert told(standing(3.0), *ALL)[0].min() > np.log(0.1 / DIRECTIONS) - 1e-9

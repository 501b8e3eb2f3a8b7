"""Boxes of upper bodies from joints."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_persons.body.standing import WAIST
from followspot_persons.body.upper_body_box import LEVELS, upper_bodies
from followspot_persons.pose_net.movenet import COCO

TOP, HEIGHT, MIDDLE = 50.0, 300.0, 120.0
WIDTHS = {"shoulder": 30.0, "hip": 18.0, "eye": 5.0, "ear": 10.0}


def upright() -> np.ndarray:
    """Joints of a person, (17, 2) px, who faces the camera: the left side is on the right."""
    pixel = np.zeros((17, 2))
    for i, name in enumerate(COCO):
        side, _, part = name.rpartition("_")
        sign = {"left": 1, "right": -1}.get(side, 0)
        level = LEVELS.get(part, 0.2)
        pixel[i] = MIDDLE + sign * WIDTHS.get(part, 0.0), TOP + (1 - level) * HEIGHT
    return pixel


def found(*parts: str) -> np.ndarray:
    return np.array([[float(name.endswith(parts)) for name in COCO]])


def expected() -> list[float]:
    height = (1 - WAIST) * HEIGHT
    return [MIDDLE - height / 3, TOP, MIDDLE + height / 3, TOP + height]


@pytest.mark.parametrize(
    "parts", [("nose", "eye", "ear", "shoulder", "hip"), ("nose", "shoulder"), ("shoulder", "hip")]
)
def test_a_box_reaches_from_the_top_of_the_head_to_the_waist(parts):
    assert upper_bodies(COCO, upright()[None], found(*parts))[0] == pytest.approx(expected())


def test_one_side_of_the_body_is_enough():
    weight = found("nose", "left_shoulder", "left_hip")
    box = upper_bodies(COCO, upright()[None], weight)[0]
    assert box[[1, 3]] == pytest.approx([expected()[1], expected()[3]])
    assert box[[0, 2]].mean() == pytest.approx(MIDDLE + 24)


def test_limbs_do_not_count_and_neither_does_what_was_not_found():
    pixel = upright()
    pixel[7:11] = 9999
    pixel[13:] = 9999
    pixel[0] = -500
    weight = found("eye", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
    assert upper_bodies(COCO, pixel[None], weight)[0] == pytest.approx(expected())


def test_a_surer_joint_counts_more():
    pixel = upright()
    pixel[[11, 12], 1] += 30
    weight = found("nose", "eye", "ear", "shoulder", "hip")
    low = upper_bodies(COCO, pixel[None], weight)[0, 3]
    weight[0, [11, 12]] = 0.01
    assert low > upper_bodies(COCO, pixel[None], weight)[0, 3] > expected()[3] - 2


@pytest.mark.parametrize("parts", [("nose", "eye", "ear"), ("shoulder",), ("hip",), ("wrist", "knee")])
def test_joints_at_one_height_determine_no_box(parts):
    assert np.isnan(upper_bodies(COCO, upright()[None], found(*parts))).all()


def test_a_body_upside_down_has_no_box_and_nobody_has_none():
    pixel = upright() * [1, -1]
    assert np.isnan(upper_bodies(COCO, pixel[None], found("nose", "shoulder", "hip"))).all()
    assert upper_bodies(COCO, np.zeros((0, 17, 2)), np.zeros((0, 17))).shape == (0, 4)


def test_a_network_without_trunks_gives_no_boxes():
    for joints in (("nose",), ("left_wrist", "mouth")):
        pixel = np.zeros((2, len(joints), 2))
        assert np.isnan(upper_bodies(joints, pixel, np.ones((2, len(joints))))).all()

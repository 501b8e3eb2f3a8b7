"""Distances of boxes, boxes on bodies, and points carried between boxes."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_persons.box_geometry import ARMS, SHOULDERS, box_distance, carried, on_body

BOX = np.array([[100.0, 50.0, 140.0, 130.0]])


def test_the_distance_of_boxes_is_that_of_middles_and_sizes_in_heights_of_the_detected_one() -> None:
    expected = np.array([[130.0, 90.0, 170.0, 170.0], [100.0, 50.0, 140.0, 90.0]])
    middle = np.hypot(30, 40) / 80
    other = np.hypot(20 / 80, np.log(0.5))
    assert box_distance(expected, BOX)[:, 0] == pytest.approx([middle, other])
    assert box_distance(BOX, BOX) == pytest.approx(0)


def test_boxes_on_both_sides_of_the_seam_of_a_panorama_are_near() -> None:
    across = BOX + np.array([1396, 0, 1396, 0])
    assert box_distance(across, BOX, turn=1396) == pytest.approx(0)
    assert box_distance(across, BOX) == pytest.approx(1396 / 80)
    assert on_body(across, BOX, turn=1396).all()
    assert not on_body(across, BOX).any()


@pytest.mark.parametrize(
    ("right", "down", "there"),
    [
        (0, 0, True),
        (80 * ARMS - 1, 0, True),
        (80 * ARMS + 1, 0, False),
        (-80 * ARMS - 1, 0, False),
        (0, -39, True),  # the middle is at the head's top
        (0, -41, False),
        (0, 119, True),  # at the feet
        (0, 121, False),
    ],
)
def test_a_box_is_on_a_body_if_its_middle_is_down_to_a_height_below(
    right: float, down: float, there: bool
) -> None:
    moved = BOX + np.array([right, down, right, down])
    assert on_body(moved, BOX).tolist() == [there]
    assert on_body(moved, np.vstack([BOX + 1000.0, BOX])).tolist() == [there]  # of any body
    assert on_body(moved, BOX[:0]).tolist() == [False]


def test_what_surely_is_an_upper_body_is_no_arm_beside_another() -> None:
    half = (ARMS + SHOULDERS) / 2
    for certainty, limit in ((0.0, ARMS), (0.5, half), (1.0, SHOULDERS)):
        near, far = (BOX + np.array([right, 0, right, 0]) for right in (80 * limit - 1, 80 * limit + 1))
        both = np.concatenate([near, far])
        assert on_body(both, BOX, certainty=np.full(2, certainty)).tolist() == [True, False]


def test_points_are_carried_by_the_heights_of_boxes_from_the_middle_of_the_upper_side() -> None:
    points = np.array([[120.0, 50.0], [130.0, 90.0]])
    to = np.array([200.0, 10.0, 300.0, 170.0])
    assert carried(points, BOX[0], to) == pytest.approx(np.array([[250.0, 10.0], [270.0, 90.0]]))

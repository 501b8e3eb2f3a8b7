"""Which finds of a network are one person."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_persons.pose_net.contract import People
from followspot_persons.pose_net.duplicates import distinct


def people(*columns: float, certainty: float = 0.9) -> People:
    """Bodies of five joints, 100 px high and 40 px wide, one beside the other; the second is the surest."""
    body = np.array([[0, 0], [40, 20], [0, 40], [40, 60], [20, 100.0]])
    pixel = np.array([body + np.array([column, 0]) for column in columns])
    score = 0.5 + 0.1 * np.arange(len(columns))[::-1]
    score[1:2] = 0.9
    return People(pixel, np.full(pixel.shape[:2], certainty), score)


def test_the_surest_of_close_finds_is_kept_first():
    assert distinct(people(0, 3, 200), 0.2, 0.5, 0).tolist() == [1, 2]
    assert distinct(people(0, 3, 200), 0.2, 1.0, 0).tolist() == [1, 0, 2]
    assert distinct(people(), 0.2, 0.5, 0).tolist() == []


def test_joints_that_are_not_certain_say_nothing_of_likeness():
    found = people(0, 0)
    found.certainty[:, 1:] = 0.1
    found.pixel[0, 0] += 60
    assert distinct(found, 0.2, 0.5, 0).tolist() == [1, 0]
    found.pixel[0, 0] -= 60
    found.pixel[0, 1:] += 60
    assert distinct(found, 0.2, 0.5, 0).tolist() == [1]


def test_finds_without_a_joint_in_common_are_two_people():
    found = people(0, 0)
    found.certainty[0, :2], found.certainty[1, 2:] = 0, 0
    assert len(distinct(found, 0.2, 0.5, 0)) == 2


@pytest.mark.parametrize(("turn", "count"), [(0, 2), (1396, 1)])
def test_columns_of_a_panorama_wrap_around(turn: int, count: int):
    assert len(distinct(people(1390, -4), 0.2, 0.5, turn)) == count

"""Inertial readings that wait for the next preview."""

from __future__ import annotations

import numpy as np

from followspot import Header
from followspot.inertial import Inertial
from followspot.messages import stamped
from followspot_dashboard.unshown_readings import MAXIMUM_WAITING, UnshownReadings


def reading(number: int) -> Inertial:
    zeros = np.zeros((1, 3))
    message = Inertial("wand", np.array([number], "i8"), zeros, zeros, zeros)
    return stamped(message, Header("imu", number, number))


def test_all_readings_since_the_last_preview_are_shown_once() -> None:
    unshown = UnshownReadings()
    for number in range(3):
        unshown.add(reading(number))
    shown = unshown.take()
    assert (shown.time.tolist(), shown.header.seq) == ([0, 1, 2], 2)
    unshown.add(reading(3))
    assert unshown.take().time.tolist() == [3]


def test_the_oldest_readings_are_left_out_if_no_preview_takes_them() -> None:
    unshown = UnshownReadings()
    for number in range(MAXIMUM_WAITING + 2):
        unshown.add(reading(number))
    assert unshown.take().time.tolist() == list(range(2, MAXIMUM_WAITING + 2))

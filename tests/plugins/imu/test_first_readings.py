"""The units of a sensor are doubted once, by its first readings."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_imu.network.first_readings import ENOUGH, FirstReadings


@pytest.mark.parametrize("parts", [(ENOUGH,), (ENOUGH - 1, 1), (ENOUGH - 1, 9)])
def test_units_are_doubted_when_there_are_enough_readings_and_never_again(parts: tuple[int, ...]) -> None:
    first = FirstReadings()
    found = [first.doubts(np.zeros((count, 3)), np.full((count, 3), 1e3)) for count in (*parts, ENOUGH)]
    assert [list(doubts) for doubts in found] == [*([] for _ in parts[1:]), ["force_unit"], []]

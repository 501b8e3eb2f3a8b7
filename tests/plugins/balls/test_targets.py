"""What a forecast says of the targets: the stages of a worker share it, and none of them can change it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from followspot import Array
from followspot.tracking import LOST, MISSING, PREDICTED, TRACKED, Forecast
from followspot_balls.scene.targets import lost_targets, tracked_targets

STATES = [TRACKED, MISSING, LOST, PREDICTED]


def forecast() -> Forecast:
    """A forecast of four targets, each in another state."""
    zero = np.zeros((4, 3))
    state = np.array(STATES, np.uint8)
    return Forecast(1 / 30, state, zero, zero, np.zeros((4, 3, 3)), zero, zero)


def test_a_forecast_says_which_targets_are_lost_and_which_were_tracked() -> None:
    assert lost_targets(forecast(), 4).tolist() == [False, False, True, False]
    assert tracked_targets(forecast(), 4).tolist() == [True, False, False, True]


def test_before_the_first_forecast_all_targets_are_lost_and_none_was_tracked() -> None:
    assert lost_targets(None, 2).tolist() == [True, True]
    assert tracked_targets(None, 2).tolist() == [False, False]


@pytest.mark.parametrize("asked", [lost_targets, tracked_targets])
def test_who_shares_the_answer_cannot_change_it(asked: Callable[[Forecast, int], Array]) -> None:
    one = forecast()
    assert asked(one, 4) is asked(one, 4)
    with pytest.raises(ValueError, match="read-only"):
        asked(one, 4)[0] = True

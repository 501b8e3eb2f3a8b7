"""When `calibrate check` believes that a camera moved: a step or slope that is large, sure and explains."""

from __future__ import annotations

import numpy as np
import pytest

from followspot.messages import Array
from followspot_calibrate.check.drift import Change, change, course

ROWS = 1200
TIME = np.linspace(0.0, 40.0, ROWS)
NOISE = np.random.default_rng(3).normal(0, 1.0, (ROWS, 2))
"""px; of 24 windows, each of 50 sightings that say as much as 12: 0.5 px of the median of one."""


def found(shift: Array, rows: int = ROWS) -> Change | None:
    """The change that residuals tell whose first column is shifted by (N,) px."""
    residual = (NOISE + np.column_stack([shift, np.zeros(ROWS)]))[:rows]
    return change(course("cam0", TIME[:rows], residual), TIME[:rows], residual)


@pytest.mark.parametrize(("size", "believed"), [(1.2, False), (4.0, True)])
def test_a_step_is_believed_from_four_sigma_on(size: float, believed: bool) -> None:
    step = found(np.where(TIME > 13, size, 0.0))
    assert (step is not None) is believed
    if step is not None:
        assert step.at == pytest.approx(13, abs=0.2)
        assert step.by == pytest.approx([size, 0], abs=0.3)


def test_a_camera_that_is_off_now_here_now_there_did_not_move_once() -> None:
    assert found(np.where(np.arange(ROWS) // 50 % 2, 6.0, -6.0)) is None


def test_the_slope_is_that_of_the_whole_recording() -> None:
    slope = found(TIME / TIME[-1] * 8.0)
    assert slope is not None
    assert slope.at is None
    assert slope.by == pytest.approx([8.0, 0.0], abs=0.8)


@pytest.mark.parametrize(("rows", "windows"), [(59, 3), (60, 4), (10, 0)])
def test_fewer_than_four_windows_of_fifteen_sightings_tell_nothing(rows: int, windows: int) -> None:
    step = np.where(np.arange(ROWS) >= rows // 2, 20.0, 0.0)
    assert len(course("cam0", TIME[:rows], NOISE[:rows]).time) == windows
    assert (found(step, rows) is not None) is (windows == 4)


def test_sightings_that_no_other_camera_confirms_are_left_out() -> None:
    shift = np.where(TIME > 13, 4.0, 0.0)
    shift[::3] = np.nan
    step = found(shift)
    assert step is not None
    assert step.at == pytest.approx(13, abs=0.2)

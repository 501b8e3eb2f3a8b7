"""The benchmarks of filters: what they compare, and which frames they count as flight and as hits."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("filterpy")
from bench.balls import filter_speed, motion_models


def test_all_filters_follow_the_same_targets() -> None:
    given = filter_speed.positions(targets=2, frames=29)
    for name, stage in filter_speed.filters(2).items():
        stage.setup()
        outputs = [stage.process(message) for message in given]
        assert outputs[-1].tracks.target.tolist() == [0, 1], name
    assert set(filter_speed.measure(1, 5, 1)) == {"balls.kalman", *filter_speed.MODELS}


def test_flight_and_hits_are_told_by_the_acceleration() -> None:
    seconds = np.arange(60) / 30
    thrown = np.where(seconds < 1.0, 5.0 * seconds - 4.905 * seconds**2, 0.095)
    thrown[:10] = thrown[10]
    places = np.column_stack([0 * seconds, 0 * seconds, thrown])
    flight, hit = motion_models.motions(np.round(seconds * 1e9).astype(int), places)
    assert flight[14:27].all()
    assert not flight[:9].any()
    assert not flight[34:].any()
    assert hit[29:31].all()
    assert not hit[15:26].any()
    assert not (flight & hit).any()


def test_an_error_is_counted_once_at_its_frame() -> None:
    assert motion_models.rmse_mm([np.array([0.003]), np.array([0.004, 0.0])]) == pytest.approx(
        1e3 * np.sqrt(25e-6 / 3)
    )
    assert np.isnan(motion_models.rmse_mm([np.zeros(0)]))

"""Real inertial sensors: paths through gaps, and orientations, beside the figures of a plain fit."""

from __future__ import annotations

import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from bench.balls import inertial
from bench.balls.inertial import Setting
from benching.inertial_trial import Trial, read

REAL = dataset("imu-broad")
needs_broad = needs_data("imu-broad")
TRIALS = sorted(inertial.BASELINE)


def trial(number: str) -> Trial:
    return read(next(REAL.glob(f"{number}_*.npz")))


@needs_broad
@pytest.mark.thorough
def test_real_sensor_carries_a_fast_path_through_gaps() -> None:
    setting = Setting(start=18.0, end=54.0)
    found = inertial.figures([inertial.run(trial("15"), setting, 40)], setting.rate)
    then, _ = inertial.BASELINE["15"]
    assert (np.array(found["gap_mm"]) < 0.8 * np.array(then)).all()
    assert found["orientation_deg"][0] < 2.0
    assert found["inside_percent"][0] > 90
    assert found["inside_percent"][1] > 99


@needs_broad
@pytest.mark.thorough
@pytest.mark.parametrize("number", TRIALS)
def test_every_real_trial_is_better_than_a_plain_fit(number: str) -> None:
    setting = Setting()
    runs = [inertial.run(trial(number), setting, seed) for seed in (50, 51, 52)]
    found = inertial.figures(runs, setting.rate)
    then, _ = inertial.BASELINE[number]
    assert (np.array(found["gap_mm"]) < 0.9 * np.array(then)).all()
    assert found["orientation_deg"][0] < 2.7
    assert found["inside_percent"][0] > 88
    assert found["inside_percent"][1] > 99


def test_gaps_are_a_second_in_every_three() -> None:
    times = np.arange(0, 10, 0.01)
    hidden = inertial.hidden_at(times, 2.005)
    assert hidden[:200].max() == 0
    assert hidden[250] == pytest.approx(0.5, abs=0.011)
    assert hidden.max() == pytest.approx(1.03, abs=0.02)
    assert hidden[320:490].max() == 0
    assert np.mean(hidden[200:800] > 0) == pytest.approx(1.03 / 3, abs=0.01)

"""`balls.inertial` with two sensors on one target: the fix with the smaller sigma counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.inertial_paths import ROOM, SENSOR, Motion, orientations, position, readings

from followspot import Array, Context, Room, Sensor
from followspot.tracking import PREDICTED
from followspot_balls.inertial.stage import InertialFilter

SILENT, HIDDEN, END = 2.9, 3.0, 3.5
"""When one sensor falls silent, when the target is hidden, and the end, s."""
NAMES = ("imu", "other")


def errors_while_hidden(*silent: str) -> Array:
    """Distances from the truth in the frames in which the target is hidden, (M,) m, NaN without a position.

    silent: names of the sensors that fall silent before; the sensors are 4 cm apart.
    """
    sensors = {name: Sensor(name, "imu", rate=SENSOR.rate, mount=SENSOR.mount) for name in NAMES}
    stage = InertialFilter(Context(name="track", room=Room(targets=ROOM.targets, sensors=sensors)))
    stage.setup()
    sent, turns = [], []
    for seed, name in enumerate(NAMES):
        motion = Motion(1, arm=(0.02 - 0.04 * seed, 0.0, 0.01))
        own = [m for m in readings(motion, END, seed=seed) if name not in silent or m.time[-1] < SILENT * 1e9]
        turns += [replace(m, sensor=name) for m in orientations(motion, own, heading=1.0 + seed)]
        sent += [replace(m, sensor=name) for m in own]
    found, before = [], -1
    for time in np.arange(0.1, END, 1 / 60):
        now = round(time * 1e9)
        window = [tuple(m for m in each if before < m.header.time <= now) for each in (sent, turns)]
        truth = Motion(1).xyz(np.array([time]))[0]
        tracks = stage.process(position(None if time > HIDDEN else truth, time), *window).tracks
        if time > HIDDEN:
            bridged = tracks.state.tolist() == [PREDICTED]
            found.append(np.linalg.norm(tracks.xyz[0] - truth) if bridged else np.nan)
        before = now
    return np.array(found)


@pytest.mark.parametrize("silent", ["imu", pytest.param("other", marks=pytest.mark.thorough)])
def test_one_sensor_takes_over_from_the_other_that_falls_silent(silent: str) -> None:
    assert errors_while_hidden(silent).max() < 0.03


@pytest.mark.thorough
def test_target_is_not_bridged_when_both_are_silent() -> None:
    assert np.isnan(errors_while_hidden(*NAMES)[-1])

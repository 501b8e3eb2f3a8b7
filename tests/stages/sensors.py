"""Stages for tests of what is shown of sensors: two sources, and tracks with orientations. For --plugin."""

from __future__ import annotations

import numpy as np

from followspot import Array, Message, Source, Stage, Window, at, column
from followspot.inertial import Inertial, PosedTracks
from followspot.tracking import Tracks

PERIOD = 100_000_000
"""Between two messages, ns."""


class Pressure(Message):
    """What a barometer says; the page knows nothing of it."""

    status: str
    height: Array = column("N", unit="m", decimals=3)


class Imu(Stage):
    """Ten readings a message, at rest."""

    per_sensor = True

    def process(self) -> Source[Inertial]:
        for n in range(1000):
            yield at(n * PERIOD, resting(n * PERIOD))


class Barometer(Stage):
    """One place."""

    per_sensor = True

    def process(self) -> Source[Pressure]:
        for n in range(1000):
            yield at(n * PERIOD, Pressure("well", np.array([1.25])))


class Pose(Stage):
    """Tracks with unknown orientations, after readings of all sensors."""

    def process(self, tracks: Tracks, turning: Window[Inertial], air: Window[Pressure]) -> PosedTracks:
        return posed(tracks, np.full((len(tracks.target), 4), np.nan))


def resting(time: int, step: int = 10_000_000) -> Inertial:
    """Ten readings at rest until a time, ns, so many ns apart."""
    times = time - step * np.arange(9, -1, -1)
    force = np.tile([0.0, 0.0, 9.81], (10, 1))
    return Inertial("wrist", times, np.zeros((10, 3)), force, np.full((10, 3), np.nan))


def posed(tracks: Tracks, quaternion: Array) -> PosedTracks:
    """The tracks with these orientations, (M, 4)."""
    same = {name: getattr(tracks, name) for name in Tracks.array_names}
    return PosedTracks(**same, quaternion=quaternion, orientation_sigma=np.full(len(quaternion), 0.1))

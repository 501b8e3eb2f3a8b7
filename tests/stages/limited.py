"""Cameras and sensors that never end, and stages that note what they give."""

from __future__ import annotations

import itertools
import time

import numpy as np

from followspot import Array, Latest, Message, Source, Stage, at, column


class Reading(Message):
    value: Array = column("N", 1)


def reading(number):
    return Reading(np.full((1, 1), float(number)))


class Eye(Stage):
    """A camera of 50 frames a second that begins at 1 s."""

    per_camera = True

    def process(self) -> Source[Reading]:
        for number in itertools.count():
            yield at(10**9 + number * 20_000_000, reading(number))


class Timed(Eye):
    """A camera that knows its times beforehand."""

    def capture_time(self, number: int) -> int:
        return 10**9 + number * 20_000_000


class Imu(Stage):
    """A sensor of 1000 readings a second that begins at 0 s and never ends."""

    per_sensor = True

    def process(self) -> Source[Reading]:
        for number in itertools.count():
            yield at(number * 1_000_000, reading(number))


class Device(Stage):
    """A live camera or sensor that never ends."""

    live = True

    def process(self) -> Source[Reading]:
        for number in itertools.count():
            yield at(time.time_ns(), reading(number))
            if not self.context.pause(0.002):
                return


class Note(Stage):
    """A line for each message."""

    def setup(self) -> None:
        self.lines = []

    def process(self, read: Reading) -> None:
        self.lines.append(f"{read.header.time} {read.value[0, 0]:.0f}")

    def close(self) -> None:
        (self.context.out / f"{self.context.name.rpartition('/')[2]}.txt").write_text("\n".join(self.lines))


class Pair(Stage):
    """The newest reading at each frame."""

    def process(self, frame: Reading, newest: Latest[Reading]) -> Reading:
        return reading(-1 if newest is None else newest.value[0, 0])

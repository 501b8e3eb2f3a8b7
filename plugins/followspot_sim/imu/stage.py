"""Stage `sim.imu`: an inertial sensor on a ball of the simulated room."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from followspot import Array, InputError, Source, Stage, at
from followspot.errors import Mistake
from followspot.inertial import Inertial
from followspot.rotation import inverse, turned
from followspot.sensors.reading_batches import batches
from followspot_sim.imu.errors import channel
from followspot_sim.imu.motion import Mount
from followspot_sim.imu.parameters import ImuParams
from followspot_sim.imu.path import path_of
from followspot_sim.imu.turning import Turning
from followspot_sim.sensor import own_rng
from followspot_sim.world import setting

RATE = 200.0
"""Readings a second if neither the room nor the stage says."""
STRIDE = 250
"""Readings that are computed together, about."""


class SimImu(Stage):
    """Give the readings of an inertial sensor that is mounted on a ball, while cameras see the same ball.

    Reading k is that of k / rate seconds. The parameters of the performance must equal those of the cameras.
    Ball and sensor have the same axes.
    """

    per_sensor: ClassVar[bool] = True

    class Params(ImuParams):
        """The performance, and the errors of the sensor."""

    params: Params

    def setup(self) -> None:
        """Prepare the performance. Raises InputError for a sensor that is mounted on no target."""
        p, mount = self.params, self.sensor.mount
        if mount is None or mount.set != "targets":
            remedy = "say which ball carries it, for example mount: {target: red}"
            raise InputError([Mistake(None, f"sensor {self.sensor.name} is mounted on no target", remedy)])
        self._rate = p.rate or self.sensor.rate or RATE
        self._mount = Mount(
            path_of(setting(p, self.room, p.clock_offset), self._rate),
            Turning(p.seed, len(self.room.targets), p.turn_rate),
            list(self.room.targets).index(mount.name),
            self._rate,
            p.clock_offset,
            np.array(p.lever_arm),
            p.contact_time,
        )
        self._rng = own_rng(p.seed, self.sensor.name)
        density = np.sqrt(self._rate)
        self._gyroscope = channel(self._rng, p.turn_bias_sigma, p.turn_noise * density, p.turn_limit)
        self._accelerometer = channel(self._rng, p.force_bias_sigma, p.force_noise * density, p.force_limit)
        self._magnetometer = channel(self._rng, p.field_bias_sigma, p.field_noise)

    def process(self) -> Source[Inertial]:
        """Readings from time 0 to that of the last picture."""
        begun = self.context.begun()
        for message in self._messages():
            since = int(message.time[-1])
            yield at(since, message, due=begun + since if self.params.realtime else 0)

    def _messages(self) -> Iterator[Inertial]:
        """Groups of readings, cut into messages; no message lies in two groups."""
        last = int((self.params.frames - 1) / self.params.fps * self._rate) if self.params.frames else None
        usual = next(batches(self._times(0, self.params.batch), self.params)).stop
        stride = usual * -(-STRIDE // usual)
        for first in itertools.count(0, stride):
            count = stride if last is None else min(stride, last + 1 - first)
            if count <= 0:
                return
            group = self.readings(first, count)
            yield from (group.where(rows) for rows in batches(group.time, self.params))

    def _times(self, first: int, count: int) -> Array:
        """Capture times, ns."""
        return np.round(np.arange(first, first + count) * (1e9 / self._rate)).astype("i8")

    def readings(self, first: int, count: int) -> Inertial:
        """The next readings; their noise is the next of the sensor's."""
        rate = self._gyroscope.read(self._mount.turn_rate(first, count), self._rng)
        force = self._accelerometer.read(self._mount.specific_force(first, count), self._rng)
        q = self._mount.orientation(first, count)
        field = self._magnetometer.read(turned(inverse(q), np.array(self.params.field)), self._rng)
        if not self.params.magnetometer:
            field = np.full((count, 3), np.nan)
        return Inertial(self.sensor.name, self._times(first, count), rate, force, field)

"""Base of the stages that receive the readings of one inertial sensor as datagrams."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import cached_property
from threading import Event
from typing import Any, ClassVar, NamedTuple

import numpy as np

from followspot import Array, Field, InputAddress, Source, Stage, at
from followspot.inertial import Inertial
from followspot.sensors.device_clock import DeviceClock
from followspot.sensors.reading_batches import BatchParams
from followspot_imu.network.collection import Collection
from followspot_imu.network.first_readings import FirstReadings
from followspot_imu.network.listener import Datagram, datagrams, opened
from followspot_imu.network.losses import Losses
from followspot_imu.network.tally import Tally
from followspot_imu.units import MOST, AxesParams, converted

SILENCE = 3_000_000_000
"""Time without readings after which the user is told, ns."""
TOGETHER = 200_000
"""Readings without a time of their own that arrive sooner after each other were measured longer apart, ns."""
LONGEST_WAIT = 0.2
"""Longest wait for a datagram before the stage looks whether the run ends, s."""


class Reading(NamedTuple):
    """device_time: by the sensor's clock, ns, None if it says none; values: 9, in the order of `VALUES`."""

    device_time: int | None
    values: tuple[float, ...]


class NetworkSensor(Stage, ABC):
    """Base of the sources that listen at a port; subclasses read datagrams."""

    live: ClassVar[bool] = True
    per_sensor: ClassVar[bool] = True

    class Params(AxesParams, BatchParams):
        """The port, the axes, and the size of messages."""

        host: InputAddress = Field(
            "127.0.0.1", description="own address to listen at; 0.0.0.0: all networks of this host"
        )
        port: int = Field(8000, ge=1, le=65535, unit="1", description="UDP port; each sensor has its own")
        sender: str = Field(
            "", max_length=100, description="address of the only sender that is heard; empty: any"
        )

    params: Any

    @property
    @abstractmethod
    def scale(self) -> Array:
        """(9,): from the units of the values to those of a reading."""

    @abstractmethod
    def readings(self, datagram: Datagram) -> Iterator[Reading]:
        """The readings in a datagram; unreadable ones are counted in `tally`."""

    @cached_property
    def stopped(self) -> Event:
        """Ends the listening when it is set."""
        return Event()

    @cached_property
    def tally(self) -> Tally:
        """Counts of unreadable datagrams and refused readings, which it reports as warnings."""
        return Tally(self.sensor.name, self.context.warn)

    def process(self) -> Source[Inertial]:
        """Readings with capture times by this host's clock. Raises InputError if it cannot listen."""
        p = self.params
        self._clock, self._pending = DeviceClock(), Collection(p)
        self._losses = Losses(self.sensor.rate)
        self._first = FirstReadings()
        self._arrival = 0
        self._most = MOST / np.abs(self.scale)
        own = opened(p.host, p.port)
        heard, silent = 0, False
        try:
            for datagram in datagrams(own, self.stopped.is_set, min(LONGEST_WAIT, p.batch_time)):
                for reading in self._heard(datagram):
                    heard = datagram.arrival
                    if self._added(reading, heard):
                        yield self._message()
                if self._pending.complete(datagram.arrival):
                    yield self._message()
                heard = heard or datagram.arrival
                silent = self._say_if_silent(datagram.arrival - heard > SILENCE, silent)
            if self._pending:
                yield self._message()
        finally:
            own.close()
            self.tally.tell()

    def _heard(self, datagram: Datagram) -> Iterator[Reading]:
        if not datagram.sender:
            return iter(())
        if self.params.sender not in ("", datagram.sender):
            self.tally.add("datagrams of other senders", why=datagram.sender)
            return iter(())
        return self.readings(datagram)

    def _added(self, reading: Reading, arrival: int) -> bool:
        """Collect a reading; whether the message is complete."""
        if (np.abs(reading.values) > self._most).any():
            self.tally.add("readings out of range", why="check the units that the sensor sends")
            return False
        together = reading.device_time is None and arrival - self._arrival < TOGETHER
        self._arrival = arrival
        self.tally.add(
            "readings without a time that arrived with the one before",
            int(together),
            "their motion is blurred; let the sender send its time, or each reading by itself",
        )
        before = self._clock.restarts
        time = self._clock.capture_time(reading.device_time, arrival)
        self.tally.add("restarts of the device", self._clock.restarts - before)
        self.tally.add("missing readings", self._losses.within(self._clock.interval))
        if time is None:
            self.tally.add("readings that came too late or twice")
            return False
        self._pending.add(time, reading.values)
        return self._pending.complete(time)

    def _say_if_silent(self, silent: bool, before: bool) -> bool:
        """Tell the user once that nothing comes, and once that it comes again. Returns `silent`."""
        if silent != before:
            where = f"{self.params.host}:{self.params.port}"
            self.context.warn(
                f"{self.sensor.name}: no reading arrives at {where}"
                if silent
                else f"{self.sensor.name}: readings arrive again at {where}"
            )
        return silent

    def _message(self) -> Inertial:
        time, values = self._pending.taken()
        turn_rate, force, field = converted(values, self.scale, self.params.axes)
        for parameter, doubt in self._first.doubts(turn_rate, force).items():
            unit = getattr(self.params, parameter, None)
            self.context.warn(
                f"{self.sensor.name}: {doubt}{f'; is {parameter} {unit} right?' if unit else ''}"
            )
        return at(int(time[-1]), Inertial(self.sensor.name, time, turn_rate, force, field))

    def close(self) -> None:
        """End the listening, also from another thread."""
        self.stopped.set()

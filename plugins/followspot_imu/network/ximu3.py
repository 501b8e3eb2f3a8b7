"""Stage `imu.ximu3`: an x-IMU3 by x-io Technologies that sends datagrams."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from followspot import Array, Field
from followspot_imu.network.listener import Datagram
from followspot_imu.network.sensor import NetworkSensor, Reading
from followspot_imu.network.ximu3_messages import ERROR, Malformed, Ximu3Stream
from followspot_imu.units import DEGREE, STANDARD_GRAVITY, scale_of

UNREAD = (np.nan,) * 3


class Ximu3(NetworkSensor):
    """Readings of an x-IMU3 over UDP, from its inertial and magnetometer messages, ASCII or binary.

    In the settings of the device, set its UDP send port to this stage's `port`, and its UDP IP address to
    that of this host. The device sends the time of each reading, so the stage can count lost readings.
    """

    class Params(NetworkSensor.Params):
        """The port, the axes and the magnetometer."""

        field_size: float = Field(
            50.0,
            gt=0,
            le=1000,
            unit="uT",
            description="field that the magnetometer calls 1 in its arbitrary unit",
        )

    params: Params

    @cached_property
    def scale(self) -> Array:
        """From degrees per second, g and the arbitrary unit."""
        return scale_of(DEGREE, STANDARD_GRAVITY, self.params.field_size)

    @cached_property
    def _stream(self) -> Ximu3Stream:
        return Ximu3Stream()

    def readings(self, datagram: Datagram) -> Iterator[Reading]:
        """One for each inertial message; the field is that of a magnetometer message just before it."""
        for message in self._stream.messages(datagram.data):
            if isinstance(message, Malformed):
                self.tally.add("messages that cannot be read", why=str(message))
            elif message.letter == ERROR:
                self.tally.add("errors that the device tells", why=message.text)
            elif message.letter == "M":
                self._field = message.numbers
            elif message.letter == "I":
                yield Reading(1000 * message.time, (*message.numbers, *self._field))
                self._field = UNREAD

    _field: tuple[float, ...] = UNREAD

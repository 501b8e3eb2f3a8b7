"""Stage `imu.osc`: a sensor that sends Open Sound Control, as phones and x-io's NGIMU do."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fnmatch import fnmatchcase
from functools import cached_property
from typing import Literal

from pydantic import field_validator

from followspot import Array, Field
from followspot.messages import MAX_TIME
from followspot_imu.network.listener import Datagram
from followspot_imu.network.osc_messages import OscError, OscMessage, osc_messages
from followspot_imu.network.sensor import NetworkSensor, Reading
from followspot_imu.units import FORCE, TURN, VALUES, UnitParams

WORDS = (*VALUES, "time", "-")
NANOSECONDS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}


class Osc(NetworkSensor):
    """Readings in OSC messages: each address, which may contain * and ?, has a list of names of its values.

    A reading is complete when gyroscope and accelerometer have read, in one message or in several. Its time
    is that of its arrival, unless a message has one.
    """

    class Params(NetworkSensor.Params, UnitParams):
        """The port, the messages, their units and axes."""

        messages: dict[str, str] = Field(
            {"/sensors": "gx gy gz ax ay az mx my mz"},
            description="address -> names of its values in order, of gx gy gz ax ay az mx my mz time, and - "
            "for one to leave out",
        )
        time_unit: Literal["s", "ms", "us", "ns"] = Field("s", description="unit of the value time")

        @field_validator("messages")
        @classmethod
        def _check_messages(cls, value: dict[str, str]) -> dict[str, str]:
            named = [word for text in value.values() for word in text.split()]
            strange = next((word for word in named if word not in WORDS), None)
            if strange is not None:
                raise ValueError(f'"{strange}" is no value; there are {" ".join(WORDS)}')
            if not all(address.startswith("/") for address in value):
                raise ValueError("an address begins with /")
            if not {*TURN, *FORCE} <= set(named):
                raise ValueError(f"the messages together must have {' '.join((*TURN, *FORCE))}")
            return value

    params: Params

    @cached_property
    def scale(self) -> Array:
        """From the units of the parameters."""
        return self.params.scale

    @cached_property
    def _seen(self) -> dict[str, float]:
        """Values that have arrived since the last reading, by name."""
        return {}

    def readings(self, datagram: Datagram) -> Iterator[Reading]:
        """The readings that the messages of a datagram complete."""
        try:
            messages = osc_messages(datagram.data)
        except OscError as error:
            self.tally.add("datagrams that cannot be read", why=str(error))
            return
        for message in messages:
            self._take(message)
            if all(name in self._seen for name in (*TURN, *FORCE)):
                yield self._reading()

    def _take(self, message: OscMessage) -> None:
        """Keep the values of a message whose address has names."""
        names = next(
            (t.split() for a, t in self.params.messages.items() if fnmatchcase(message.address, a)), None
        )
        if names is None:
            self.tally.add("messages to other addresses", why=message.address[:100])
        elif len(message.values) < len(names):
            self.tally.add("messages with too few values", why=message.address[:100])
        elif not all(math.isfinite(v) for n, v in zip(names, message.values, strict=False) if n != "-"):
            self.tally.add("messages with a value that is no number", why=message.address[:100])
        else:
            self._seen.update(zip(names, message.values, strict=False))

    def _reading(self) -> Reading:
        """The reading that was seen."""
        seen, time = self._seen, None
        if "time" in seen:
            said = seen["time"] * NANOSECONDS[self.params.time_unit]
            time = round(said) if abs(said) < MAX_TIME else None
            self.tally.add("times out of range: readings have that of their arrival", int(time is None))
        values = tuple(seen.get(name, math.nan) for name in VALUES)
        seen.clear()
        return Reading(time, values)

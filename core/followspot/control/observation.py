"""Requests that read how a run is: status, log, states of stages, clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import pydantic

from followspot.control.dispatch import Request, Role, RunRequest
from followspot.control.host import HostStatus
from followspot.log.record import LogPage
from followspot.messages import MAX_TIME

_LATEST = MAX_TIME - (1 << 55)
"""Latest reading of a clock that is believed, ns: a year below the end of the range of capture times."""
_Reading = Annotated[int, pydantic.Field(strict=True, ge=0, le=_LATEST)]


@dataclass(frozen=True)
class ClockReading:
    """Readings of the clocks of a host, ns. captured: wall clock, for capture times; steady: monotonic."""

    captured: _Reading
    steady: _Reading


class GetHostStatus(RunRequest):
    """How the run is on a host."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = HostStatus


class GetLog(RunRequest):
    """The log records after the one of this number."""

    after: int = -1
    roles: ClassVar[tuple[Role, ...]] = ("operator", "host")
    answer: ClassVar[Any] = LogPage


class GetStates(RunRequest):
    """The newest checkpoint of each stage on a host, as `state_to_data` gives it, by stage."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = dict[str, Any]
    long_answer: ClassVar[bool] = True


class ReadClock(Request):
    """What the clocks of a host read now; every host compares its own with them."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = ClockReading
    open_to_hosts: ClassVar[bool] = True

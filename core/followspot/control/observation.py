"""Requests that read a run: its status, log, checkpoints and clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import pydantic

from followspot.control.dispatch import Role, RunRequest
from followspot.control.host import HostStatus
from followspot.log.record import LogPage
from followspot.messages import MAX_TIME

_LATEST = MAX_TIME - (1 << 55)
"""Latest valid reading of a clock, ns: a year before the end of the range of capture times."""
_Reading = Annotated[int, pydantic.Field(strict=True, ge=0, le=_LATEST)]


@dataclass(frozen=True)
class ClockReading:
    """Readings of the clocks of a host, ns. captured: wall clock, for capture times; steady: monotonic."""

    captured: _Reading
    steady: _Reading


class GetHostStatus(RunRequest):
    """Get the status of the run on a host."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = HostStatus


class GetLog(RunRequest):
    """Get the log records after the record of this number."""

    after: int = -1
    roles: ClassVar[tuple[Role, ...]] = ("operator", "host")
    answer: ClassVar[Any] = LogPage


class GetStates(RunRequest):
    """Get the newest checkpoint of each stage on a host, as `state_to_data` gives it, by stage."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = dict[str, Any]
    long_answer: ClassVar[bool] = True


class ReadClock(RunRequest):
    """Read the clocks of a host; any host may ask, to compare them with its own.

    run: its times go on if the wall clock of the host is set; "" for that clock as it is.
    """

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = ClockReading
    open_to_hosts: ClassVar[bool] = True

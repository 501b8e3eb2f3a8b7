"""Requests from the operator to hosts about the life of a run there: prepare, start, stop, find, close."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import pydantic

from followspot.control.dispatch import Request, Role, RunRequest
from followspot.control.host import RunOrder
from followspot.control.origin import Origin
from followspot.ranges import Age

Known = Literal["here", "timed out", "unknown"]
"""How an agent knows a run; timed out: the agent ended it because its operator was silent for too long."""
_Name = Annotated[str, pydantic.Field(max_length=1000)]


@dataclass(frozen=True)
class ListedRun:
    """A run that an agent has a part of.

    detached: whether it goes on without an operator; silent_s: time since an operator last asked for it, s.
    """

    run: _Name
    graph: _Name
    over: bool
    detached: bool = False
    silent_s: Age = 0.0
    origin: Origin = Origin()


class PrepareRun(Request):
    """Start the workers of a host; they wait for `StartRun`."""

    order: RunOrder
    roles: ClassVar[tuple[Role, ...]] = ("host",)


class StartRun(RunRequest):
    """All hosts are ready: begin."""

    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


class StopRun(RunRequest):
    """End the sources; what is in flight is finished."""

    roles: ClassVar[tuple[Role, ...]] = ("operator", "host", "worker")


class EndWorkers(RunRequest):
    """These workers, on whichever host, have ended: no worker waits for them any more."""

    workers: tuple[str, ...]
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


class CloseRun(RunRequest):
    """Forget the run; workers that still live are killed."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)


class FindRun(RunRequest):
    """How the agent knows the run."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = Known


class ListRuns(Request):
    """All runs that the agent has a part of."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = list[ListedRun]


class GetOrder(RunRequest):
    """What the host was told to prepare, as it is after changes and moves."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = RunOrder
    long_answer: ClassVar[bool] = True

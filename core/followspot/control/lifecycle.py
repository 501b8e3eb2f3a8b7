"""Requests about the life cycle of a run: prepare, start, stop, find, list, close."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import pydantic

from followspot.control.dispatch import Request, Role, RunRequest
from followspot.control.host import RunOrder
from followspot.control.process_identity import ProcessIdentity
from followspot.valid_values.numbers import Age, Count, Nanoseconds

Known = Literal["here", "timed out", "unknown"]
"""How an agent knows a run; timed out: the agent ended it because its operator was silent."""
_Name = Annotated[str, pydantic.Field(max_length=1000)]


@dataclass(frozen=True)
class ListedRun:
    """A run under an agent.

    over: it has ended on this host; detached: it goes on without an operator; silent_s: time since the last
    request of an operator for it, s; operator: its process; fired: frames done on this host; age_s:
    since this agent has it, s; folder: of its outputs on this host.
    """

    run: _Name
    graph: _Name
    over: bool
    detached: bool = False
    silent_s: Age = 0.0
    operator: ProcessIdentity = ProcessIdentity()
    fired: Count = 0
    age_s: Age = 0.0
    folder: _Name = ""


class PrepareRun(Request):
    """Start the workers of a run on a host; they wait for `StartRun`."""

    order: RunOrder
    roles: ClassVar[tuple[Role, ...]] = ("host",)


class StartRun(RunRequest):
    """Start the stages: all hosts are ready.

    begun: when those of the host begin, ns of its monotonic clock; 0 in a request to a host.
    """

    begun: Nanoseconds = 0
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


class StopRun(RunRequest):
    """End the sources; workers finish the messages in flight."""

    roles: ClassVar[tuple[Role, ...]] = ("operator", "host", "worker")


class EndWorkers(RunRequest):
    """Announce workers of any host that have ended, so that no worker waits for them."""

    workers: tuple[str, ...]
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


class CloseRun(RunRequest):
    """Forget the run; kill its workers that are still alive."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)


class FindRun(RunRequest):
    """Ask whether the agent has the run, or had it; see `Known`."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = Known


class ListRuns(Request):
    """List all runs of the agent."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = list[ListedRun]


class GetOrder(RunRequest):
    """Get the order that the host prepared, with later changes and moves applied."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)
    answer: ClassVar[Any] = RunOrder
    long_answer: ClassVar[bool] = True

"""Orders from a host to a worker, over the pipe between them. Descriptors travel beside an order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

from followspot.control.dispatch import Request, Role, by_verb
from followspot.control.lifecycle import EndWorkers, StartRun, StopRun
from followspot.control.relay import Relayed
from followspot.control.swap import ChangeOrder
from followspot.control.tapping import PlaceTaps, RemoveTaps
from followspot.errors import FollowspotError, did_you_mean
from followspot.graph.plan import Plan
from followspot.transport.zenoh.network import Network
from followspot.valid_values.numbers import Count, Incarnation, Nanoseconds

Side = Literal["sending", "receiving"]
Correction = tuple[Nanoseconds, Nanoseconds, Nanoseconds]
"""Three times, ns: the offset to add to a host's capture times, the offset to add to its monotonic clock, and
the lead of its wall clock over its monotonic clock for which the first offset is valid."""


class WorkerOrder(Request):
    """Base of orders that only a worker handles."""

    roles: ClassVar[tuple[Role, ...]] = ("worker",)


class BuildWorker(WorkerOrder):
    """Build the stages and wait for `StartRun`. The memory of the ledger travels beside it."""

    worker: str
    """Name of the worker."""
    plan: dict[str, Any]
    """The plan of the run, in JSON types."""
    out: str
    """Folder for outputs."""
    frames: Count | None
    """Number of frames of each camera, None for all."""
    run: str
    """Name of the run."""
    network: Network
    incarnation: Incarnation
    """How often the worker was started before."""
    restart: bool
    """Whether the host restarts workers that die."""
    over: tuple[str, ...]
    """Workers that have ended."""
    states: dict[str, Any]
    """Checkpoints from which stages carry on, by stage."""
    clock: Correction


class TakeRing(WorkerOrder):
    """Take one end of the ring of an edge: a socket beside the order. edge: its number in the plan."""

    edge: int
    side: Side


class SendStates(WorkerOrder):
    """Send the host a checkpoint of every stage."""


class SetClock(WorkerOrder):
    """Apply a new clock correction."""

    correction: Correction


class LeaveRun(WorkerOrder):
    """Send the host a checkpoint of every stage and exit, although the streams have not ended."""


class HoldSources(Relayed):
    """Hold all sources of a replay; stages process the messages already sent.

    A step names a source that sends more messages before it holds, and a capture time that the other sources
    reach. In the worker of the named source the others follow its newest capture time without another order.
    """

    id: str
    """Of the order; a further one with the same id has an `until` from 0 and changes only that."""
    held: bool = True
    """False lets the sources go on."""
    source: str = ""
    """The source that sends `count` more messages before it holds, "" for none."""
    count: Count = 0
    until: Nanoseconds = -1
    """Capture time that the other sources reach before they hold, ns."""

    def check(self, plan: Plan, *, remote: bool) -> None:
        """Raise FollowspotError if the run is live or has no such source."""
        if plan.live:
            raise FollowspotError("a live run cannot be paused: its devices do not wait")
        fed = {edge.to_stage for edge in plan.edges}
        known = [stage.name for stage in plan.stages if stage.name not in fed]
        if self.source and self.source not in known:
            remedy = did_you_mean(self.source, known, "sources")
            raise FollowspotError(f'there is no source "{self.source}"; {remedy}')

    def check_after(self, before: Relayed) -> None:
        """Raise FollowspotError if this changes an order in whose place there is another by now."""
        if self.until >= 0 and isinstance(before, HoldSources) and before.id != self.id:
            done = "paused the run or made it step" if before.held else "let the run go on"
            raise FollowspotError(f"another command has {done} meanwhile")

    def standing(self, before: Sequence[Relayed]) -> list[Relayed]:
        """Only the newest order counts, and workers that start later are free without one."""
        others = [order for order in before if not isinstance(order, HoldSources)]
        return [*others, self] if self.held else others


class EndSensors(Relayed):
    """End sources of sensors: those of a replay after a capture time, live ones at once.

    sensors: names of the sources; time: of the last message that one may send, ns.
    """

    sensors: tuple[str, ...]
    time: Nanoseconds


RELAYED: tuple[type[Relayed], ...] = (PlaceTaps, RemoveTaps, HoldSources, EndSensors)
"""Orders that the operator relays to all workers."""
ORDERS = by_verb(
    (
        BuildWorker,
        TakeRing,
        StartRun,
        StopRun,
        EndWorkers,
        SendStates,
        SetClock,
        LeaveRun,
        ChangeOrder,
        *RELAYED,
    )
)

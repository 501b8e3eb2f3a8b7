"""What a stage is doing right now, and on whom it waits: answers "why is it slow" at a glance."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from followspot.ranges import Age, Count, Figure
from followspot.runtime.cell import Cell
from followspot.runtime.clock import Clock
from followspot.runtime.inlet import Inlet
from followspot.runtime.ledger import COLUMNS, tally
from followspot.runtime.outlet import Outlet
from followspot.runtime.source import LiveCell
from followspot.runtime.worker import Worker
from followspot.transport.token import END

StageState = Literal["starting", "getting", "waiting", "processing", "sending", "old", "absent", "over"]
"""getting: an input is empty, or the device has nothing; waiting: it has all that it needs, but its worker is
at another stage; sending: an output is full; absent: all it listens to is away, or its worker.

For those who look on: starting: nothing was heard of it yet; old: nothing was heard of it lately.
"""


@dataclass(frozen=True)
class EdgeAge:
    """How old, ms since they entered the graph, the last messages of an edge were when its stage took them.

    error: why one was refused last, "" where none was.
    """

    name: str
    p50_ms: Figure | None
    p95_ms: Figure | None
    error: str = ""


@dataclass(frozen=True)
class StageStatus:
    """One stage at one moment.

    on: the edges that it waits for, by name, or the stage that its worker is at; error: the last one, "" for
    none; edges: that lead to it; idle_s: time, s, in which it has not fired, as far as that was noticed.
    """

    stage: str
    state: StageState
    on: tuple[str, ...] = ()
    fired: Count = 0
    skipped: Count = 0
    restarts: Count = 0
    busy_ms: Figure = 0.0
    error: str = ""
    edges: tuple[EdgeAge, ...] = ()
    idle_s: Age = 0.0


@dataclass(frozen=True)
class PathStatus:
    """Latency from a source to a sink so far, ms."""

    origin: str
    sink: str
    p50_ms: Figure
    p95_ms: Figure


def stages_now(worker: Worker, errors: Mapping[str, str]) -> tuple[StageStatus, ...]:
    """All stages of a worker; safe from another thread, which may see them between two steps.

    errors: the last warning of each stage.
    """
    at_work = next((cell.name for cell in worker.cells if cell.working), "")
    return tuple(_status(cell, errors.get(cell.name, ""), at_work) for cell in worker.cells)


class Idleness:
    """Since when each stage has not fired, as far as whoever looks again and again can tell.

    monotonic: a clock, s.
    """

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._clock = monotonic
        self._since: dict[str, tuple[int, float]] = {}

    def noted(self, stages: Iterable[StageStatus]) -> Iterator[StageStatus]:
        """The same stages as they are now, with the time in which they have not fired."""
        now = self._clock()
        for stage in stages:
            fired, since = self._since.get(stage.stage, (-1, now))
            since = since if fired == stage.fired else now
            self._since[stage.stage] = stage.fired, since
            yield replace(stage, idle_s=round(max(0.0, now - since), 3))  # two threads may look at once


def paths_now(worker: Worker) -> tuple[PathStatus, ...]:
    """Latency of all paths that end in a worker; safe from another thread."""
    return tuple(
        PathStatus(origin, cell.name, path.quantile(0.5), path.quantile(0.95))
        for cell in worker.cells
        for origin, path in tuple(cell.paths.items())
    )


def _status(cell: Cell, error: str, at_work: str) -> StageStatus:
    state, on = _state(cell, at_work)
    inlets = (*cell.join.members, *(held.inlet for held in cell.join.held))
    invalid = next((f"{i.name}: {i.invalid_reason}" for i in inlets if i.invalid_reason), "")
    count = cell.count
    busy = round(count.busy_ns / 1e6, 3)
    return StageStatus(
        cell.name,
        state,
        on,
        count.fired,
        count.skipped,
        count.restarts,
        busy,
        error or invalid,
        tuple(_age(inlet, cell.clock) for inlet in inlets),
    )


def _age(inlet: Inlet, clock: Clock) -> EdgeAge:
    ages = sorted(inlet.ages.copy())
    if not ages:
        return EdgeAge(inlet.name, None, None, inlet.invalid_reason)
    p50, p95 = (round((ages[int(share * len(ages))] + clock.steady) / 1e6, 3) for share in (0.5, 0.95))
    return EdgeAge(inlet.name, p50, p95, inlet.invalid_reason)


def _full(outlet: Outlet) -> Iterator[str]:
    """Edges that hold up an output: the full ones of this worker, of those to others who is behind most."""
    yield from (inlet.name for inlet in outlet.inlets if len(inlet.queue) >= inlet.depth)
    words = outlet.words
    behind = {name: tally(words[row : row + COLUMNS].tolist()).in_flight for name, row in outlet.edges}
    most = max(behind.values(), default=0)
    yield from (name for name, waiting in behind.items() if waiting == most > 0)


def _state(cell: Cell, at_work: str) -> tuple[StageState, tuple[str, ...]]:
    """What a stage is doing, and on whom it waits; at_work: the stage that its worker is at, "" for none."""
    if cell.done:
        return "over", ()
    if cell.absent:
        return "absent", tuple(inlet.name for inlet in cell.join.members)
    if cell.blocked:
        return "sending", tuple(name for _, outlet in cell.outlets for name in _full(outlet))
    if cell.working:
        return "processing", ()
    dry = tuple(i.name for i in cell.join.members if not i.queue and i.bound != END) or _held_up(cell)
    if dry or (isinstance(cell, LiveCell) and cell.grabbing):
        return "getting", dry
    return "waiting", (at_work,) if at_work else ()


def _held_up(cell: Cell) -> tuple[str, ...]:
    """Feedback that the next firing waits for."""
    times = [queue[0].header.time for queue in (i.queue.copy() for i in cell.join.members) if queue]
    if not times:
        return ()
    return tuple(held.inlet.name for held in cell.join.held if not held.ready(min(times)))

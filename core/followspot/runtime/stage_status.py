"""What a stage is doing right now, and on whom it waits: answers "why is it slow" at a glance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from followspot.runtime.cell import Cell
from followspot.runtime.worker import Worker
from followspot.transport.token import END

StageState = Literal["getting", "processing", "sending", "absent", "over"]
"""getting: an input is empty; sending: an output is full; absent: all it listens to is away."""


@dataclass(frozen=True)
class StageStatus:
    """One stage at one moment. on: the edges that it waits for, by name; error: the last one, "" for none."""

    stage: str
    state: StageState
    on: tuple[str, ...] = ()
    fired: int = 0
    skipped: int = 0
    restarts: int = 0
    busy_ms: float = 0.0
    error: str = ""


@dataclass(frozen=True)
class PathStatus:
    """Latency from a source to a sink so far, ms."""

    origin: str
    sink: str
    p50_ms: float
    p95_ms: float


def stages_now(worker: Worker, errors: Mapping[str, str]) -> tuple[StageStatus, ...]:
    """All stages of a worker; safe from another thread, which may see them between two steps.

    errors: the last warning of each stage.
    """
    return tuple(_status(cell, errors.get(cell.name, "")) for cell in worker.cells)


def paths_now(worker: Worker) -> tuple[PathStatus, ...]:
    """Latency of all paths that end in a worker; safe from another thread."""
    return tuple(
        PathStatus(origin, cell.name, path.quantile(0.5), path.quantile(0.95))
        for cell in worker.cells
        for origin, path in tuple(cell.paths.items())
    )


def _status(cell: Cell, error: str) -> StageStatus:
    state, on = _state(cell)
    inlets = (*cell.join.members, *(held.inlet for held in cell.join.held))
    invalid = next((f"{i.name}: {i.invalid_reason}" for i in inlets if i.invalid_reason), "")
    count = cell.count
    busy = round(count.busy_ns / 1e6, 3)
    return StageStatus(
        cell.name, state, on, count.fired, count.skipped, count.restarts, busy, error or invalid
    )


def _state(cell: Cell) -> tuple[StageState, tuple[str, ...]]:
    if cell.done:
        return "over", ()
    if cell.absent:
        return "absent", ()
    if cell.blocked:
        return "sending", tuple(i.name for _, o in cell.outlets for i in o.inlets if len(i.queue) >= i.depth)
    dry = tuple(i.name for i in cell.join.members if not i.queue and i.bound != END)
    return ("getting", dry) if dry else ("processing", ())

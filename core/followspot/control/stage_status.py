"""The status of a stage at one moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from followspot.valid_values.numbers import Age, Count, Figure, Nanoseconds

StageState = Literal[
    "starting", "getting", "waiting", "processing", "sending", "paused", "old", "absent", "over"
]
"""getting: an input is empty, or the device has no data; waiting: its inputs are complete, its worker runs
another stage; sending: an output is full; paused: the operator holds the source; absent: all its upstream
workers are absent, or its own.

The operator adds: starting: the stage has sent no status yet; old: its last status is old.
"""


@dataclass(frozen=True)
class EdgeAge:
    """Age of the last messages of an edge when its stage took them, ms since they entered the graph."""

    name: str
    """The name of the edge."""
    p50_ms: Figure | None
    p95_ms: Figure | None
    error: str = ""
    """Why the last rejected message was rejected, "" if none was."""


@dataclass(frozen=True)
class StageStatus:
    """The status of a stage."""

    stage: str
    state: StageState
    on: tuple[str, ...] = ()
    """Names of the edges that it waits for, or of the stage that its worker runs."""
    fired: Count = 0
    skipped: Count = 0
    restarts: Count = 0
    busy_ms: Figure = 0.0
    """Time spent in the stage, ms."""
    error: str = ""
    """Its last error, "" for none."""
    edges: tuple[EdgeAge, ...] = ()
    """The edges of its inputs."""
    idle_s: Age = 0.0
    """Time since it last fired, s."""
    time: Nanoseconds = -1
    """Newest capture time that a source has sent, ns; -1 for other stages."""
    hold: str = ""
    """Id of the order that holds a source, "" if none does."""


@dataclass(frozen=True)
class PathStatus:
    """Latency of a path from a source to a sink until now, ms."""

    origin: str
    """The stage of the graph file that is the source."""
    sink: str
    p50_ms: Figure
    p95_ms: Figure
    count: Count = 0
    """Messages so far."""
    budget_ms: Figure | None = None
    """The longest time allowed, None if the path has no budget."""
    late: Count = 0
    """Messages that took longer than the budget."""
    recent_ms: Figure | None = None
    """95th percentile of the newest messages, None if they are few."""

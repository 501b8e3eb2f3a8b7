"""The status of a stage at one moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from followspot.ranges import Age, Count, Figure, Nanoseconds

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
    """Age of the last messages of an edge when its stage took them, ms since they entered the graph.

    name: of the edge; error: why the last rejected message was rejected, "" if none was.
    """

    name: str
    p50_ms: Figure | None
    p95_ms: Figure | None
    error: str = ""


@dataclass(frozen=True)
class StageStatus:
    """The status of a stage.

    on: names of the edges that it waits for, or the stage that its worker runs; fired, skipped, restarts:
    counts; busy_ms: time spent in the stage, ms; error: its last error, "" for none; edges: its inputs;
    idle_s: time since it last fired, s; time: newest capture time that a source has sent, ns; hold: id of the
    order that holds a source.
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
    time: Nanoseconds = -1
    hold: str = ""


@dataclass(frozen=True)
class PathStatus:
    """Latency from a source to a sink until now, ms.

    count: messages; budget_ms: the longest time allowed, None if the path has no budget; late: messages that
    took longer; recent_ms: 95th percentile of the newest messages, None if they are few.
    """

    origin: str
    sink: str
    p50_ms: Figure
    p95_ms: Figure
    count: Count = 0
    budget_ms: Figure | None = None
    late: Count = 0
    recent_ms: Figure | None = None

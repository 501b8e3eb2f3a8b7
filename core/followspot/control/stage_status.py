"""What a stage is doing at one moment, as operators are told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from followspot.ranges import Age, Count, Figure, Nanoseconds

StageState = Literal[
    "starting", "getting", "waiting", "processing", "sending", "paused", "old", "absent", "over"
]
"""getting: an input is empty, or the device has nothing; waiting: it has all that it needs, but its worker is
at another stage; sending: an output is full; paused: the
operator holds the source; absent: all it listens to is away, or its worker.

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
    none; edges: that lead to it; idle_s: time, s, in which it has not fired, as far as that was noticed;
    time: newest capture time that a source has sent, ns; hold: id of the order that holds a source.
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
    """Latency from a source to a sink so far, ms."""

    origin: str
    sink: str
    p50_ms: Figure
    p95_ms: Figure

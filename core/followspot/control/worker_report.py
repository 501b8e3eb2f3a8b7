"""The report of a worker at its end."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from followspot.control.path_latency import PathLatency
from followspot.log.record import Said
from followspot.valid_values.numbers import Count, Figure, Nanoseconds

RUN_AGAIN = "the results are not whole, so run the replay again"


@dataclass(frozen=True)
class StageReport:
    """The figures of one stage in a run.

    busy_ms: time on the clock, ms: what other programs took counts; time: capture time of the last message of
    a source, ns, -1 of other stages; exhausted: whether the stream of a source ended by itself.
    """

    stage: str
    fired: Count
    skipped: Count
    restarts: Count
    busy_ms: Figure
    time: Nanoseconds = -1
    exhausted: bool = False


@dataclass(frozen=True)
class WorkerReport:
    """The report of one worker. frames: messages that its sources sent; error: "" if it ended cleanly;
    absent: True if the worker was not there at the end of the run.
    """

    worker: str
    frames: Count
    stages: tuple[StageReport, ...] = ()
    paths: tuple[PathLatency, ...] = ()
    warnings: tuple[Said, ...] = ()
    error: Said = ""
    absent: bool = False

    def to_data(self) -> dict[str, Any]:
        """The report in JSON types."""
        return asdict(self)

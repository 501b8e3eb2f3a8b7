"""What a worker reports at its end."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from followspot.control.path_latency import PathLatency
from followspot.ranges import Count, Figure

RUN_AGAIN = "the results are not whole, so run the replay again"


@dataclass(frozen=True)
class StageReport:
    """What one stage did in a run."""

    stage: str
    fired: Count
    skipped: Count
    restarts: Count
    busy_ms: Figure


@dataclass(frozen=True)
class WorkerReport:
    """What one worker did; error is empty where it ended cleanly.

    absent: whether it was not there at the end of the run.
    """

    worker: str
    frames: Count
    stages: tuple[StageReport, ...] = ()
    paths: tuple[PathLatency, ...] = ()
    warnings: tuple[str, ...] = ()
    error: str = ""
    absent: bool = False

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return asdict(self)

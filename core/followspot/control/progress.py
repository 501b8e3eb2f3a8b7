"""The progress of a worker or a run, and reports of it to the caller of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """How far a worker or a run has come."""

    fired: int
    """Firings of the sink that is furthest behind; of the sources if there are no sinks."""
    time: int
    """Newest capture time that a source sent, ns; -1 before the first."""
    faults: tuple[str, ...] = ()
    """Of a run: one line for each part that is absent or silent."""
    unfinished: tuple[str, ...] = ()
    """Of a run that was stopped: the sinks that may still write."""


OnProgress = Callable[[Progress, int | None], None]
"""Gets the progress and the expected number of frames (None if unknown) a few times a second."""
PROGRESS_PERIOD = 0.2
"""Seconds between two progress reports."""

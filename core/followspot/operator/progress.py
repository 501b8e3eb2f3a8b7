"""Progress reports of a run to its caller."""

from __future__ import annotations

from collections.abc import Callable

from followspot.worker.scheduler import Progress

OnProgress = Callable[[Progress, int | None], None]
"""Gets the progress and the expected number of frames (None if unknown) a few times a second."""
PROGRESS_PERIOD = 0.2
"""Seconds between two progress reports."""

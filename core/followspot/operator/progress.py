"""How a run tells its caller how far it is."""

from __future__ import annotations

from collections.abc import Callable

from followspot.worker.scheduler import Progress

OnProgress = Callable[[Progress, int | None], None]
"""Called a few times a second with the progress and the expected number of frames."""
PROGRESS_PERIOD = 0.2
"""Seconds between two reports of progress."""

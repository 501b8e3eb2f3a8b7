"""The rest of a worker: everything that its sources sent has been processed, so its graph may change."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.sources import Sources

REST_TIMEOUT = 20.0
"""Seconds in which the stages of a replay must come to rest before its graph changes."""


class Rest(NamedTuple):
    """An action for the moment when a worker is at rest.

    act: called with whether it is at rest; deadline: s, monotonic, when to act anyway; calm: whether
    nothing waits here for what live sources or other workers have yet to give.
    """

    act: Callable[[bool], None]
    deadline: float
    calm: Callable[[], bool]

    def reached(self, sources: Sources, runners: Iterable[StageRunner]) -> bool:
        """Whether a worker with nothing to fire is at rest: nothing comes from its sources or its stages."""
        return sources.still() and self.calm() and not any(runner.asks for runner in runners)

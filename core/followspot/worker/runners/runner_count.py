"""The counts of a stage runner."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class RunnerCount:
    """How often a stage fired, was skipped or restarted, and how long it worked."""

    fired: int = 0
    skipped: int = 0
    restarts: int = 0
    busy_ns: int = 0

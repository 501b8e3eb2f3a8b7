"""Functions for commands that leave a run to its agents, and that become its operator again."""

from __future__ import annotations

from followspot.operator.attach import FoundRun, attached_run, detach, runs_under
from followspot.operator.launch import interruptible

__all__ = ["FoundRun", "attached_run", "detach", "interruptible", "runs_under"]

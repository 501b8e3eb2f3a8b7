"""Leave a run to its agents, and become its operator again: what the commands for that import."""

from __future__ import annotations

from followspot.operator.attach import attached, detach
from followspot.operator.launch import interruptible

__all__ = ["attached", "detach", "interruptible"]

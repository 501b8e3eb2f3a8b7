"""The checkpoints of a host's stages as a file: stages carry on although the agent died with its workers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from followspot.files import read_bytes
from followspot.graph.plan import Plan

_SAVE_PERIOD = 1.0
"""Seconds between two saves."""


class CheckpointFile:
    """Keeps the newest checkpoint of each stage, as `state_to_data` gives it, with the stage's class."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._next = 0.0

    def left(self, plan: Plan) -> dict[str, Any]:
        """The checkpoints that an earlier agent left, of stages that are of the same class in this plan."""
        with suppress(OSError, ValueError, TypeError, AttributeError):  # none, or of another version
            kept = json.loads(read_bytes(self._path))
            uses = {stage.name: stage.uses for stage in plan.stages}
            return {name: state for name, (used, state) in kept.items() if uses.get(name) == used}
        return {}

    def keep(self, states: Mapping[str, Any], plan: Plan, now: float) -> None:
        """Save the checkpoints if the last save is old enough; now: monotonic time, s."""
        if now < self._next or not states:
            return
        self._next = now + _SAVE_PERIOD
        kept = {stage.name: (stage.uses, states[stage.name]) for stage in plan.stages if stage.name in states}
        with suppress(OSError):  # a full disk must not end the run
            new = self._path.with_suffix(".new")
            new.write_text(json.dumps(kept))
            new.replace(self._path)

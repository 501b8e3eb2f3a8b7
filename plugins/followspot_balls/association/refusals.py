"""Warning of targets that are never recovered because all views together contradict the pairs of blobs."""

from __future__ import annotations

from typing import Any

import numpy as np

_FEW = 10
"""Frames in which the positions of a target are refused, from which on the user is warned."""


class Refusals:
    """Counts refused positions of targets that were not found yet."""

    def __init__(self, targets: tuple[str, ...]) -> None:
        self.targets = targets
        self.found = np.zeros(len(targets), bool)
        self.frames = np.zeros(len(targets), int)
        """(T,) frames in which positions of each target were refused."""

    def warning(self) -> str:
        """The warning after a run, which names the targets that all views kept from being found; else ""."""
        never = (~self.found & (self.frames >= _FEW)).nonzero()[0]
        if not len(never):
            return ""
        listed = ", ".join(f'"{self.targets[t]}" ({self.frames[t]} frames)' for t in never)
        return (
            f"never found, though pairs of blobs were evidence: {listed}. All views together made the "
            "places unlikely (`least_recovery_evidence`), for cameras that see them showed nothing there. Of "
            "targets in the room, check the templates and these cameras (`followspot calibrate targets`, "
            "`followspot calibrate check`), leave out cameras that do not work (`--cameras`), or lower "
            "least_recovery_evidence"
        )

    def state(self) -> Any:
        return {"found": self.found, "frames": self.frames}

    def restore(self, state: Any) -> None:
        self.found, self.frames = np.array(state["found"], bool), np.array(state["frames"], int)

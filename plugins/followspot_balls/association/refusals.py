"""Warns of targets that are never found because all views together contradict the pairs that show them."""

from __future__ import annotations

from typing import Any

import numpy as np

_FEW = 10
"""Number of frames with refused positions of a target from which on the user is warned."""


class Refusals:
    """Counts the frames in which positions of each target were refused."""

    def __init__(self, targets: tuple[str, ...]) -> None:
        self.targets = targets
        self.found = np.zeros(len(targets), bool)
        self.frames = np.zeros(len(targets), int)
        """(T,) frames in which positions of each target were refused."""

    def warning(self) -> str:
        """The warning at the end of a run that names targets that were refused and never found; or ""."""
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

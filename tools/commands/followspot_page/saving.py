"""Saves what was changed in a run, from the page or elsewhere, as a graph file in its output folder."""

from __future__ import annotations

import time

from followspot.errors import FollowspotError
from followspot.files import unused_path
from followspot.library.handle import RunHandle
from followspot.library.overlay import save_overlay


def saved_overlay(run: RunHandle) -> str:
    """A line with the new file and the stages that it changes. Raises FollowspotError."""
    out = run.surroundings().out
    if out is None:
        raise FollowspotError("overlays are saved on the operator's host; save it there")
    path = unused_path(out / time.strftime("overlay-%Y%m%d-%H%M%S.yaml"))
    stages = save_overlay(run, path)
    return f"saved {', '.join(stages)} in {path}; followspot run {path} begins so"

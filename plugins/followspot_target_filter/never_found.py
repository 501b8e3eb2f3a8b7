"""Targets that a filter never found, though it found others."""

from __future__ import annotations

from followspot.messages import Array
from followspot.room import Room


def never_found(room: Room, found: Array) -> str:
    """The warning after a run that names the targets that were not found; "" if none is to be told.

    With ground truth the scores tell, and if nothing was found at all the run does.
    found: (T,) bool.
    """
    if room.truth is not None or not found.any() or found.all():
        return ""
    named = dict(zip(room.targets, found.tolist(), strict=True))
    missing, there = (", ".join(name for name in named if named[name] is was) for was in (False, True))
    return (
        f"never found: {missing} (found: {there}). If they were shown, look at their templates "
        "(`followspot calibrate targets`)"
    )

"""Targets that a filter did not find, though it found others."""

from __future__ import annotations

from followspot.messages import Array
from followspot.room import Room


def not_found(room: Room, found: Array) -> str:
    """The warning that names the targets that were not found, "" without one.

    There is none if the room has ground truth, because the scores tell it, and if no target was found,
    because the run then says that the stage gave nothing. found: (T,) bool, of the room's targets.
    """
    if room.truth is not None or not found.any() or found.all():
        return ""
    named = dict(zip(room.targets, found.tolist(), strict=True))
    missing, there = (", ".join(name for name in named if named[name] is was) for was in (False, True))
    return (
        f"not found: {missing} (found: {there}). If they were shown, look at their templates "
        "(`followspot calibrate targets`), or at their names in tables of other programs"
    )

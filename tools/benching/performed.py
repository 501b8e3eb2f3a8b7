"""Simulated rooms in other performances: the same cameras and targets, other people, ways and light."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from followspot.room import Room, StageUse


def performed(room: Room, seed: int, frames: int) -> Room:
    """The room in the performance of a seed."""
    change = {"seed": seed, "frames": frames}
    cameras = {name: replace(one, source=_with(one.source, change)) for name, one in room.cameras.items()}
    return replace(room, cameras=cameras, truth=_with(room.truth, change))


def _with(use: StageUse | None, params: Mapping[str, Any]) -> StageUse | None:
    return None if use is None else StageUse(use.uses, {**use.params, **params})

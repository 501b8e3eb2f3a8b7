"""Slots of the targets of a room, in the order of the room file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from followspot.inertial import PosedTracks
from followspot.messages import Array
from followspot.plain_values import to_plain
from followspot.rotation import canonical
from followspot.tracking import Tracks
from followspot_sinks.slots.slots import LARGEST, Slots, sendable

LEAST = 1e-6
"""Size of a quaternion below which it tells no orientation."""


class TargetSlots:
    """The slots of a room's targets. names: of all targets, in the order of the room file."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.slots = replace(Slots.free(len(names)), names=names)

    def after(self, tracks: Tracks) -> Slots:
        """The slots after one frame of targets."""
        self.slots = with_tracks(self.slots, tracks)
        return self.slots

    def state(self) -> Any:
        """The slots, with the last known position of each target."""
        return to_plain(self.slots)

    def restore(self, state: Any) -> None:
        """Carry on from this state."""
        names = self.slots.names
        self.slots = replace(Slots.restored(state, len(names)), names=names)


def with_tracks(slots: Slots, tracks: Tracks) -> Slots:
    """The slots after one frame of targets; target t has row t. A target with values beyond `LARGEST` is not
    known, one that the room does not have has no slot.
    """
    known = np.zeros_like(slots.known)
    position, velocity = slots.position.copy(), slots.velocity.copy()
    ours = (tracks.target >= 0) & (tracks.target < len(known))
    tracks = tracks.where(ours & sendable(np.hstack([tracks.xyz, tracks.velocity])))
    known[tracks.target] = True
    position[tracks.target] = tracks.xyz
    velocity[tracks.target] = tracks.velocity
    quaternion = _turned(slots.quaternion, tracks) if isinstance(tracks, PosedTracks) else slots.quaternion
    return Slots(slots.names, known, position, velocity, slots.heading, quaternion)


def _turned(quaternion: Array, tracks: PosedTracks) -> Array:
    """The orientations (N, 4) after one frame; a target whose orientation is not known now keeps its last."""
    size = np.abs(tracks.quaternion).max(axis=1)
    tracks = tracks.where((size > LEAST) & (size < LARGEST))
    quaternion = quaternion.copy()
    quaternion[tracks.target] = canonical(tracks.quaternion)
    return quaternion

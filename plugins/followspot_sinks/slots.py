"""Numbered slots for shows, each with a position, a velocity and whether its object is tracked now.

Lights, sound and pictures are patched to numbers before the show, so an object keeps its slot. The order of
the room file gives a target its slot; a person gets the lowest free slot, and keeps it until deleted.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from followspot import Field, StageParams
from followspot.frame_times import SECOND
from followspot.inertial import PosedTracks
from followspot.messages import Array
from followspot.people import Poses
from followspot.plain_values import from_plain, to_plain
from followspot.rotation import canonical, rotation_vector
from followspot.tracking import Tracks

FARTHEST = 1e6
"""Largest number (m, m/s, rad) that is sent; larger ones exceed the range of receivers."""
LEAST = 1e-6
"""Size of a quaternion below which it says nothing."""


@dataclass(frozen=True)
class Slots:
    """N slots, 1 to N in rows 0 to N - 1; an object that is not tracked now keeps its last values.

    names: (N,), "" for a free slot; known: (N,) bool; position: (N, 3) m, velocity: (N, 3) m/s;
    heading: (N,) rad counter-clockwise from the room's x axis, 0 for objects without one; quaternion: (N, 4)
    as in `followspot.inertial.PosedTracks`, NaN for objects without one.
    """

    names: tuple[str, ...]
    known: Array
    position: Array
    velocity: Array
    heading: Array
    quaternion: Array

    @staticmethod
    def free(count: int) -> Slots:
        """Free slots."""
        zeros, unknown = np.zeros((count, 3)), np.full((count, 4), np.nan)
        return Slots(("",) * count, np.zeros(count, bool), zeros, zeros, np.zeros(count), unknown)

    @staticmethod
    def restored(state: Any, count: int) -> Slots:
        """The first `count` slots of a state that `to_plain` made; those that it lacks are free."""
        old, free = from_plain(Slots, state), Slots.free(count)
        kept = min(count, len(old.names))
        columns = ("known", "position", "velocity", "heading", "quaternion")
        parts = {
            name: np.concatenate([getattr(old, name)[:kept], getattr(free, name)[kept:]]) for name in columns
        }
        return Slots((*old.names[:kept], *free.names[kept:]), **parts)

    @property
    def oriented(self) -> Array:
        """(N,) bool: whether an object has a quaternion."""
        return np.asarray(np.isfinite(self.quaternion).all(axis=1))

    @property
    def rotation(self) -> Array:
        """(N, 3) rotation vectors, rad; by the heading where there is no quaternion."""
        about_up = self.heading[:, None] * np.array([0.0, 0.0, 1.0])
        return np.where(self.oriented[:, None], rotation_vector(self.quaternion), about_up)


def with_tracks(slots: Slots, tracks: Tracks) -> Slots:
    """The slots after one frame of targets; target t has row t. A target with values beyond `FARTHEST` is not
    known, one that the room does not have has no slot.
    """
    known = np.zeros_like(slots.known)
    position, velocity = slots.position.copy(), slots.velocity.copy()
    ours = (tracks.target >= 0) & (tracks.target < len(known))
    tracks = tracks.where(ours & _meant(np.hstack([tracks.xyz, tracks.velocity])))
    known[tracks.target] = True
    position[tracks.target] = tracks.xyz
    velocity[tracks.target] = tracks.velocity
    quaternion = _turned(slots.quaternion, tracks) if isinstance(tracks, PosedTracks) else slots.quaternion
    return Slots(slots.names, known, position, velocity, slots.heading, quaternion)


def _turned(quaternion: Array, tracks: PosedTracks) -> Array:
    """The orientations (N, 4) after one frame; a target whose orientation is not known now keeps its last."""
    size = np.abs(tracks.quaternion).max(axis=1)
    tracks = tracks.where((size > LEAST) & (size < FARTHEST))
    quaternion = quaternion.copy()
    quaternion[tracks.target] = canonical(tracks.quaternion)
    return quaternion


def _meant(numbers: Array) -> Array:
    """Rows with sendable numbers only: (N, K) -> (N,) bool."""
    return np.asarray((np.abs(numbers) <= FARTHEST).all(axis=1))  # NaN is not


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


class PersonSlotParams(StageParams):
    """How persons share slots."""

    slots: int = Field(8, ge=1, le=256, unit="1", description="largest number of persons shown at a time")
    hold_time: float = Field(
        3.0, ge=0, unit="s", description="time for which a slot is kept for a person that is not seen"
    )


class PersonSlots:
    """Assigns slots to persons.

    count: of slots; persons beyond it are not shown. hold: time that a slot is kept for a person that is not
    seen, s.
    """

    def __init__(self, count: int, hold: float) -> None:
        self.slots = Slots.free(count)
        self.hold = round(hold * SECOND)
        self._row: dict[int, int] = {}
        self._seen = np.zeros(count, "i8")

    def after(self, poses: Poses) -> Slots:
        """The slots after one frame of persons; position is the top of the head. Rows with invalid numbers
        are ignored.
        """
        time, before = poses.header.time, self.slots
        poses = poses.where(_meant(np.column_stack([poses.xy, poses.height, poses.heading])))
        self._release(time - self.hold, set(poses.person.tolist()))
        holders = set(self._row)
        shown = [row for row, person in enumerate(poses.person.tolist()) if self._place(person)]
        at = np.array([self._row[int(poses.person[row])] for row in shown], int)
        known = np.zeros_like(before.known)
        position, velocity, heading = (
            before.position.copy(),
            np.zeros_like(before.velocity),
            before.heading.copy(),
        )
        place = np.column_stack([poses.xy, poses.height])[shown]
        elapsed = (time - self._seen[at])[:, None] / SECOND
        same = np.array([int(poses.person[row]) in holders for row in shown], bool)
        moving = (same & before.known[at])[:, None] & (elapsed > 0)
        velocity[at] = np.divide(place - position[at], elapsed, out=np.zeros_like(place), where=moving)
        known[at] = True
        position[at] = place
        heading[at] = poses.heading[shown]
        self._seen[at] = time
        names = [""] * len(known)
        for person, row in self._row.items():
            names[row] = f"person {person}"
        self.slots = Slots(tuple(names), known, position, velocity, heading, before.quaternion)
        return self.slots

    def state(self) -> Any:
        """The slot of each target, for `restore`: lights keep their numbers when a worker starts again."""
        return {"slots": to_plain(self.slots), "row": to_plain(self._row), "seen": self._seen}

    def restore(self, state: Any) -> None:
        """Carry on from this state; persons in slots beyond the present number lose them."""
        count = len(self._seen)
        self.slots = Slots.restored(state["slots"], count)
        rows = from_plain(dict[int, int], state["row"])
        self._row = {person: row for person, row in rows.items() if row < count}
        kept = min(count, len(state["seen"]))
        self._seen[:kept] = state["seen"][:kept]

    def _release(self, oldest: int, present: Collection[int]) -> None:
        """Free the slots of persons that were last seen before this time, ns, and are not present now."""
        self._row = {
            person: row for person, row in self._row.items() if person in present or self._seen[row] >= oldest
        }

    def _place(self, person: int) -> bool:
        """Whether the person has a slot now."""
        if person not in self._row:
            free = set(range(len(self._seen))) - set(self._row.values())
            if not free:
                return False
            self._row[person] = min(free)
        return True


Keeper = TypeVar("Keeper", TargetSlots, PersonSlots)


class KeepsSlots(Generic[Keeper]):
    """Base of sinks that keep their slots when their worker is started again; `keeper` has them."""

    keeper: Keeper

    def state(self) -> Any:
        """The slots."""
        return self.keeper.state()

    def restore(self, state: Any) -> None:
        """Carry on from this state."""
        self.keeper.restore(state)

"""Slots of persons: each gets the lowest free one, and keeps it until it has not been seen for some time."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from followspot import Field, StageParams
from followspot.frame_times import SECOND
from followspot.messages import Array
from followspot.people import Poses
from followspot.plain_values import from_plain, to_plain
from followspot_sinks.slots.slots import Slots, sendable


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
        """Row of each person who has a slot."""
        self._seen = np.zeros(count, "i8")
        """(N,) ns, when the person of each slot was seen last."""

    def after(self, poses: Poses) -> Slots:
        """The slots after one frame of persons; rows with invalid numbers are ignored.

        The position is that of the top of the head; the velocity of a person who is not seen is 0.
        """
        time, before = poses.header.time, self.slots
        poses = poses.where(sendable(np.column_stack([poses.xy, poses.height, poses.heading])))
        persons = poses.person.tolist()
        self._release(time - self.hold, set(persons))
        holders = set(self._row)
        shown = [n for n, person in enumerate(persons) if self._place(person)]
        row = np.array([self._row[persons[n]] for n in shown], int)
        again = np.array([persons[n] in holders for n in shown], bool) & before.known[row]
        place = np.column_stack([poses.xy, poses.height])[shown]
        velocity = np.zeros_like(before.velocity)
        velocity[row] = _velocity(before.position[row], place, time - self._seen[row], again)
        self._seen[row] = time
        self.slots = Slots(
            self._names(),
            _with(np.zeros_like(before.known), row, True),
            _with(before.position, row, place),
            velocity,
            _with(before.heading, row, poses.heading[shown]),
            before.quaternion,
        )
        return self.slots

    def state(self) -> Any:
        """The slot of each person: lights keep their numbers when a worker starts again."""
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

    def _names(self) -> tuple[str, ...]:
        """The name of each slot, "" if it is free."""
        names = [""] * len(self._seen)
        for person, row in self._row.items():
            names[row] = f"person {person}"
        return tuple(names)


def _velocity(before: Array, now: Array, elapsed: Array, again: Array) -> Array:
    """Velocity, (N, 3) m/s, from the last two places (N, 3) m; 0 for persons who were not seen before.

    elapsed: (N,) ns between the two; again: (N,) bool, seen in the frame before, too.
    """
    passed = elapsed[:, None] / SECOND
    moving = again[:, None] & (passed > 0)
    return np.asarray(np.divide(now - before, passed, out=np.zeros_like(now), where=moving))


def _with(column: Array, rows: Array, values: Any) -> Array:
    """A copy of a column with other values in some rows."""
    changed = column.copy()
    changed[rows] = values
    return changed

"""Known distances between points, and the groups of points that they tie together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.messages import Array


@dataclass(frozen=True, eq=False)
class Rods:
    """Pairs of rows with a known distance: the bulbs of a wand, the corners of a board.

    first, second: (S,) row numbers; length: (S,) or one for all, m; sigma: of the length, m.
    """

    first: Array
    second: Array
    length: Array | float
    sigma: float

    def __len__(self) -> int:
        return len(self.first)

    def within(self, usable: Array) -> Rods:
        """The rods with two usable ends, with row numbers among the usable rows; usable: (N,) bool."""
        chosen = usable[self.first] & usable[self.second]
        number = np.cumsum(usable) - 1
        length = np.broadcast_to(self.length, self.first.shape)[chosen]
        return Rods(number[self.first[chosen]], number[self.second[chosen]], length, self.sigma)

    def errors(self, points: Array) -> tuple[Array, Array]:
        """Length errors, (S,) sigmas, and their derivative by the first end, (S, 3) (minus by the second)."""
        along = points[self.first] - points[self.second]
        distance = np.linalg.norm(along, axis=1)
        direction = along / np.maximum(distance, np.finfo(float).tiny)[:, None]
        return (distance - self.length) / self.sigma, direction / self.sigma


NO_RODS = Rods(np.empty(0, int), np.empty(0, int), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Group:
    """Sets of g points each, connected by rods within a set and by none between sets.

    members: (G, g) rows; rods: (S,) that connect them; where: set, index of the first end and index of
    the second end of each of these rods, (3, S).
    """

    members: Array
    rods: Array
    where: Array


def groups_of(count: int, rods: Rods) -> list[Group]:
    """The points in sets that rods tie together, by the size of the sets; without rods all are single."""
    label = _components(count, rods)
    order = np.argsort(label, kind="stable")
    _, start, sizes = np.unique(label[order], return_index=True, return_counts=True)
    groups = []
    for size in np.unique(sizes):
        members = order[start[sizes == size][:, None] + np.arange(size)]
        place = np.full((2, count), -1)
        place[0, members] = np.arange(len(members))[:, None]
        place[1, members] = np.arange(size)
        chosen = np.flatnonzero(place[0, rods.first] >= 0)
        first, second = rods.first[chosen], rods.second[chosen]
        where = np.stack([place[0, first], place[1, first], place[1, second]])
        groups.append(Group(members, chosen, where))
    return groups


def _components(count: int, rods: Rods) -> Array:
    """The lowest row of the set that each row belongs to, (count,)."""
    label = np.arange(count)
    while True:
        low = np.minimum(label[rods.first], label[rods.second])
        spread = label.copy()
        np.minimum.at(spread, rods.first, low)
        np.minimum.at(spread, rods.second, low)
        if (spread == label).all():
            return label
        label = spread

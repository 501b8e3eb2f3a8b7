"""Density of clutter at each place of each view, learnt from the blobs there while a target was lost.

Lamps, paint and reflectors stay in place; a ball that returns appears at a new place. A blob is therefore
stronger evidence if its view showed no blob nearby while the target was lost.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.room import Room

ACROSS = 40
"""Cells over the width of a picture. A blob counts in its cell and the eight around it."""
EVERY = 3
"""The map learns from every third frame. The number is odd, because a missing target is searched for
everywhere only in every second frame: with an even number the map could learn from the other frames alone."""
USUAL = 0.42
"""Usual number of blobs in a cell and the eight around it, in one frame. `ViewParams.clutter` is 0.015 blobs
in a square whose side is the radius of a ball's image. With a radius of 0.014 of the picture's width, the
nine cells, 3 / `ACROSS` of the width on each side, have the area of 28 such squares."""
KNOWN = 4.0
"""Weight of the usual clutter, as a number of learnt frames: the prior of a rate (a gamma distribution)."""
NEW = 0.5
"""Share of the usual clutter below which a blob counts as new: its view has hardly shown any there."""
FEW = 3
"""Largest number of new blobs of a target in one view: the target, a part of it, and another moving thing. If
there are more, lights have come on or a lens was uncovered, and clutter counts as usual."""
HEAVIEST = 1e6
"""Weight of a frame above which all weights are scaled down."""
TALLEST = 4 * ACROSS
"""Largest number of rows of cells; blobs farther down count in the last one."""
LONGEST = 50.0
"""Longest time without a learnt frame, over the memory; after it everything is forgotten."""
BORDER = 2
"""Cells outside a picture on each side: one for blobs there, one around it."""
AROUND = np.array([(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)])
"""Offsets of a cell and its neighbours."""


class ClutterMap:
    """Decaying counts of blobs around each cell of C views, for each of T targets."""

    def __init__(self, room: Room, memory: float) -> None:
        """memory: frames after which a blob counts for 1/e."""
        size = np.array([camera.size for camera in room.cameras.values()], float).reshape(-1, 2)
        self.cell = size[:, 0] / ACROSS
        self.down = np.minimum(np.ceil(size[:, 1] / self.cell), TALLEST).astype(int)
        """(C,) rows of cells in a picture."""
        count = len(room.targets)
        shape = len(size), int(self.down.max(initial=0)) + 2 * BORDER, ACROSS + 2 * BORDER, count
        self.counts = np.zeros(shape)
        """(C, rows, columns, T), blobs around each cell in the learnt frames, times the frames' weights."""
        self.learnt = np.zeros((len(size), count))
        """(C, T), sums of the weights of the learnt frames."""
        self.memory, self.weight = memory, 1.0
        self.frame = self.last = 0

    def learn(self, sending: Array, view: Array, xy: Array, targets: Array, lost: Array) -> None:
        """Learn from a frame, at most from every third, if some target is lost in it.

        sending: numbers of the views that sent; view: (N,) of each blob; xy: (N, 2) px; targets: (N, T) bool;
        lost: (T,) bool.
        """
        self.frame += 1
        if self.frame - self.last < EVERY or not np.count_nonzero(lost):
            return
        self.weight, self.last = self.weight_now(), self.frame
        if self.weight > HEAVIEST:
            self.normalise()
        self.learnt[np.ix_(sending, lost)] += self.weight
        mine = targets & lost
        row = np.flatnonzero(mine.any(axis=1))
        place = self.place(view[row], xy[row])[:, None] + AROUND
        np.add.at(self.counts, (view[row, None], place[..., 0], place[..., 1]), self.weight * mine[row, None])

    def share(self, view: Array, xy: Array, targets: Array, lost: Array) -> Array:
        """Share of the usual clutter around each blob: (N,), at most 1, the smallest over its targets.

        The share is 1 if a blob can be no lost target, if nothing was learnt, if its view shows more than
        `FEW` new blobs at once, and if at least the usual number of blobs was there: a ball that only one
        view has seen so far must not count as its own clutter. Arguments as for :meth:`learn`.
        """
        place = self.place(view, xy)
        usual = KNOWN * self.weight_now()
        counts = self.counts[view, place[:, 0], place[:, 1]] / USUAL
        share = np.where(targets & lost, (usual + counts) / (usual + self.learnt[view]), 1.0)
        new = share < NEW
        together = np.zeros(self.learnt.shape)
        np.add.at(together, view, new)
        share[new & (together[view] > FEW)] = 1.0
        return np.asarray(share.min(axis=1, initial=1.0))

    def weight_now(self) -> float:
        """The weight of a frame that is learnt now: older ones count for less, the longer ago they were."""
        return self.weight * float(np.exp(min((self.frame - self.last) / self.memory, LONGEST)))

    def normalise(self) -> None:
        """Make the weight of a frame 1 again, which changes no share."""
        self.counts /= self.weight
        self.counts[self.counts < 1 / HEAVIEST] = 0.0
        self.learnt /= self.weight
        self.weight = 1.0

    def place(self, view: Array, xy: Array) -> Array:
        """Row and column of the cell of each blob: (N, 2). Those outside a picture are in its border."""
        column, row = np.floor(xy / self.cell[view, None]).T
        inside = [np.fmin(np.fmax(row, -1), self.down[view]), np.fmin(np.fmax(column, -1), ACROSS)]
        return np.stack(inside, axis=1).astype(int) + BORDER

    def state(self) -> dict[str, Any]:
        """What was learnt, as plain values; most cells are empty."""
        (filled,) = self.counts.reshape(-1).nonzero()
        counts = self.counts.reshape(-1)[filled]
        return {
            "cells": filled.astype(np.int32),
            "counts": counts,
            "learnt": self.learnt.copy(),
            "weight": self.weight,
            "frames": np.array([self.frame, self.last]),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of a map of the same room."""
        self.counts[...], self.weight = 0.0, float(state["weight"])
        self.counts.reshape(-1)[state["cells"]] = state["counts"]
        self.learnt = np.array(state["learnt"], float)
        self.frame, self.last = (int(number) for number in state["frames"])

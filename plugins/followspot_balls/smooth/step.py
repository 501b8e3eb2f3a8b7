"""One moment in a smoother's memory: the tracks and the observed positions of that time."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple, Self

import numpy as np

from followspot import Array, Message
from followspot.tracking import Positions, Tracks


class Observation(NamedTuple):
    """Positions of M distinct targets from one message."""

    target: Array
    """(M,) numbers."""
    xyz: Array
    """(M, 3) m."""
    noise: Array
    """(M, 3, 3) m^2."""
    sure: Array
    """(M,) bool, those that may show a bounce."""
    late: Array
    """() bool, whether it came after the tracks of its time."""


def of_room(message: Positions | Tracks, count: int) -> Array:
    """Rows of the room's `count` targets that have a place, bool."""
    known = (message.target >= 0) & (message.target < count)
    return np.asarray(known & np.isfinite(message.xyz).all(axis=1))


def observation(
    positions: Positions, count: int, sigma: float, minimum_support: int, *, late: bool
) -> Observation:
    """The positions of the room's `count` targets; sigma: of those without a covariance, m."""
    rows = of_room(positions, count)
    target = positions.target.astype(np.intp)
    known = np.isfinite(positions.covariance).all(axis=(1, 2), keepdims=True)
    noise = np.where(known, positions.covariance, np.eye(3) * sigma**2)
    sure = positions.support >= minimum_support
    return Observation(target[rows], positions.xyz[rows], noise[rows], sure[rows], np.array(late))


@dataclass(frozen=True)
class Step:
    """What one moment contributes to the smoother: the tracks of its frame, and what was observed then.

    time: ns; seq: number of the tracks, -1 without; tracks: None if there are only positions; observed: the
    positions of each fusion.
    """

    time: int
    seq: int = -1
    tracks: Tracks | None = None
    observed: tuple[Observation, ...] = ()

    def to_data(self) -> dict[str, Any]:
        """The step as a part of a checkpoint."""
        return {
            "time": self.time,
            "seq": self.seq,
            "tracks": None if self.tracks is None else _columns(self.tracks),
            "observed": [one._asdict() for one in self.observed],
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """The step of a checkpoint."""
        tracks = data["tracks"]
        observed = [_observation(one) for one in data["observed"]]
        return cls(
            int(data["time"]),
            int(data["seq"]),
            None if tracks is None else Tracks(**{name: np.array(value) for name, value in tracks.items()}),
            tuple(observed),
        )


def insert(steps: list[Step], one: Step) -> int:
    """Insert a step in the order of time, or merge it with that of its time. Returns its index."""
    index = bisect_left(steps, one.time, key=attrgetter("time"))
    if index < len(steps) and steps[index].time == one.time:
        there = steps[index]
        kept = one if one.tracks is not None else there
        steps[index] = Step(one.time, kept.seq, kept.tracks, there.observed + one.observed)
    else:
        steps.insert(index, one)
    return index


def _columns(message: Message) -> dict[str, Array]:
    return {column.name: np.array(getattr(message, column.name)) for column in message.columns}


def _observation(data: Mapping[str, Any]) -> Observation:
    return Observation(**{name: np.array(data[name]) for name in Observation._fields})

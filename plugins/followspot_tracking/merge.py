"""Stage `tracking.merge`: tracks of overlapping sub-rooms, each target once."""

from __future__ import annotations

from typing import Any

import numpy as np

from followspot import Array, Field, Joined, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.tracking import PREDICTED, TRACKED, Tracks
from followspot_tracking.estimates import Estimates, confidence, gathered, intersection, of_room


class Merge(Stage):
    """Merge tracks of several trackers in one frame of reference: each target once, without jumps.

    Trackers share the room's targets, so a target keeps its identity when it goes from one zone to another.
    Estimates that agree are fused by covariance intersection. If a tracker begins or ceases to see a target,
    or becomes less sure of it, the merged position goes on without a jump and approaches the new fusion
    within `handover_time`. So a bias between zones causes no jump. A tracker that disagrees by more than
    `gate` is left out as long as another tracker continues with the target.
    """

    class Params(StageParams):
        gate: float = Field(
            0.3,
            gt=0,
            unit="m",
            description="largest distance between trackers that agree; raising it merges larger biases",
        )
        handover_time: float = Field(
            0.5,
            gt=0,
            unit="s",
            description="time constant in which a bias between zones is taken over; raising it hands over "
            "more smoothly",
        )

    params: Params

    def setup(self) -> None:
        """Begin without targets."""
        count = len(self.room.targets)
        self.time = -1
        self.known = np.zeros(count, bool)
        self.xyz, self.velocity = np.zeros((2, count, 3))
        self.strange = False
        self.used = np.zeros((0, count), bool)
        self.seen = np.zeros((0, count, 3))

    def process(self, tracks: Joined[Tracks]) -> Tracks:
        if not tracks:
            return Tracks.empty()
        time = tracks[0].header.time
        elapsed = max(time - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        if not self.strange and not all(of_room(one, len(self.known)).all() for one in tracks):
            self.strange = True
            self.context.warn("tracks of targets that the room does not have are left out")
        found = gathered(tracks, len(self.known))
        ahead = self.xyz + self.velocity * elapsed
        used, continued = self.chosen(found, ahead)
        weights = intersection(found, used)
        fused = weights.mean(found.xyz)
        fading = np.exp(-elapsed / self.params.handover_time) * continued
        offset = fading[:, None] * (self.moved(found, used, ahead) - fused)
        spread = weights.mean((found.xyz - fused) ** 2)
        self.time, self.known = time, np.asarray(used.any(axis=0))
        self.xyz, self.velocity = fused + offset, weights.mean(found.velocity)
        self.used, self.seen = used, found.xyz
        measured = np.asarray((used & found.measured).any(axis=0))
        return self.merged(measured, weights.variance + spread + offset**2)

    def chosen(self, found: Estimates, ahead: Array) -> tuple[Array, Array]:
        """The estimates that are used, (S, T) bool, and the targets that go on with their track, (T,) bool.

        Of a known target, those near the place that is expected, ahead, (T, 3) m. If there are none, or if
        the target is new: the surest one, measured ones first, and those near it.
        """
        near = found.there & self.known & (_distance(found.xyz, ahead) <= self.params.gate)
        continued = np.asarray(near.any(axis=0))
        surest = np.where(found.measured, 1.0, 1e-12) * confidence(found)
        best = found.xyz[surest.argmax(axis=0), np.arange(len(self.known))]
        around = found.there & (_distance(found.xyz, best) <= self.params.gate)
        return np.where(continued, near, around), continued

    def moved(self, found: Estimates, used: Array, ahead: Array) -> Array:
        """The merged positions moved on as the trackers move that are used and were before, (T, 3) m.

        Without such a tracker a position moves with its velocity, to `ahead`. With the same trackers and
        weights as before, the distance from the fusion stays the same.
        """
        if used.shape != self.used.shape:  # a message is missing, and which one is not known
            return ahead
        remaining = used & self.used
        motion = intersection(found, remaining).mean(found.xyz - self.seen)
        return np.where(remaining.any(axis=0, keepdims=True).T, self.xyz + motion, ahead)

    def merged(self, measured: Array, variance: Array) -> Tracks:
        """The message; measured: (T,) bool; variance: (T, 3) m^2."""
        target = self.known.nonzero()[0]
        return Tracks(
            target=target.astype(np.int32),
            state=np.where(measured, TRACKED, PREDICTED).astype(np.uint8)[target],
            xyz=self.xyz[target],
            velocity=self.velocity[target],
            sigma=np.sqrt(variance[target]),
        )

    def state(self) -> Any:
        names = ("time", "known", "xyz", "velocity", "used", "seen")
        return {name: getattr(self, name) for name in names}

    def restore(self, state: Any) -> None:
        self.time = int(state["time"])
        for name in ("known", "xyz", "velocity", "used", "seen"):
            setattr(self, name, np.array(state[name]))


def _distance(xyz: Array, place: Array) -> Array:
    """Distances of (S, T, 3) from (T, 3), m."""
    return np.asarray(np.linalg.norm(xyz - place, axis=2))

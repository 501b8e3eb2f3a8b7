"""Smoothing, forecast and life cycle of targets (Jin & Qian 2008, sections 3.7 and 3.8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.tracking import LOST, MISSING, TRACKED, Forecast, Positions, Tracks
from followspot_balls.motion import Motion, predict, update

NANOSECOND = 1e-9
DEFAULT_PERIOD = 1 / 30
"""Between frames, s, until two of them were seen."""


@dataclass(frozen=True)
class Outputs:
    """What the filter gives: the targets now, and where they will be."""

    tracks: Tracks
    forecast: Forecast


class Kalman(Stage):
    """Filter each target with a first-order motion model, and keep its life cycle: tracked, missing, lost."""

    class Params(StageParams):
        acceleration: float = Field(
            12.0,
            gt=0,
            unit="m/s^2",
            description="one sigma of what moves a target; raising it follows turns faster and smooths less",
        )
        measurement: float = Field(
            0.008,
            gt=0,
            unit="m",
            description="one sigma of a position whose fusion gives no covariance; raising it smooths more",
        )
        missing: int = Field(
            25,
            ge=0,
            unit="frames",
            description="frames for which a target that is not seen is sought near its last place",
        )
        fade: float = Field(
            0.1,
            ge=0,
            unit="s",
            description="time in which the velocity of a missing target fades; 0: it stays at its last place",
        )
        speed: float = Field(3.0, gt=0, unit="m/s", description="one sigma of the velocity of a new target")

    params: Params

    def setup(self) -> None:
        count = len(self.room.targets)
        self.motion = Motion.zero(count)
        self.status = np.full(count, LOST, np.uint8)
        self.unseen = np.zeros(count, int)
        self.last = np.zeros((count, 3))
        self.before = np.zeros((count, 3))
        self.time = -1
        self.period = DEFAULT_PERIOD

    def process(self, positions: Positions) -> Outputs:
        self.advance(positions.header.time)
        known = self.status != LOST
        motion = predict(self.motion, self.period, self.params.acceleration)
        accepted = known[positions.target] | positions.confirmed
        target, xyz = positions.target[accepted], positions.xyz[accepted]
        covariance = self.noise(positions.covariance[accepted])
        new = ~known[target]
        motion = motion.started(target[new], xyz[new], covariance[new], self.params.speed)
        self.motion = update(motion, target[~new], xyz[~new], covariance[~new])
        self.age(target, new)
        return Outputs(self.tracks(), self.forecast())

    def advance(self, time: int) -> None:
        """Measure the period from capture times, ns; frame intervals may vary."""
        if self.time >= 0 and time > self.time:
            self.period = (time - self.time) * NANOSECOND
        self.time = time

    def noise(self, covariance: Array) -> Array:
        """Covariances of measurements, with the constant one where the fusion knows none."""
        constant = np.eye(3) * self.params.measurement**2
        return np.where(np.isfinite(covariance), covariance, constant)

    def age(self, target: Array, new: Array) -> None:
        """Count the frames in which a target was missing, and move on the last two estimates."""
        seen = np.zeros(len(self.status), bool)
        seen[target] = True
        self.unseen = np.where(seen, 0, self.unseen + 1)
        gone = ~seen & (self.unseen > self.params.missing)
        waiting = ~seen & (self.status != LOST) & ~gone
        self.status[seen], self.status[waiting], self.status[gone] = TRACKED, MISSING, LOST
        self.before[seen] = self.last[seen]
        self.last[seen] = self.motion.xyz[seen]
        self.before[target[new]] = self.last[target[new]]
        self.rest(waiting)

    def rest(self, waiting: Array) -> None:
        """Let missing targets come to rest near their last place."""
        keep = np.exp(-self.period / self.params.fade) if self.params.fade > 0 else 0.0
        self.motion.state[waiting, 3:] *= keep
        if keep == 0:
            self.motion.state[waiting, :3] = self.last[waiting]

    def tracks(self) -> Tracks:
        """Rows of the targets that were measured in this frame."""
        target = np.flatnonzero(self.status == TRACKED)
        variance = np.diagonal(self.motion.covariance[target, :3, :3], axis1=1, axis2=2)
        return Tracks(
            target=target.astype(np.int32),
            state=self.status[target],
            xyz=self.motion.xyz[target],
            velocity=self.motion.velocity[target],
            sigma=np.sqrt(variance),
        )

    def forecast(self) -> Forecast:
        """Where the targets will be one period from now; the rows of lost ones are zero."""
        known = self.status != LOST
        ahead = predict(self.motion, self.period, self.params.acceleration)
        keep = known[:, None]
        return Forecast(
            period=self.period,
            state=self.status.copy(),
            xyz=ahead.xyz * keep,
            velocity=ahead.velocity * keep,
            covariance=ahead.covariance[:, :3, :3] * keep[..., None],
            last=self.last * keep,
            before=self.before * keep,
        )

    def state(self) -> Any:
        return {
            "state": self.motion.state,
            "covariance": self.motion.covariance,
            "status": self.status,
            "unseen": self.unseen,
            "last": self.last,
            "before": self.before,
            "time": self.time,
            "period": self.period,
        }

    def restore(self, state: Any) -> None:
        self.motion = Motion(np.array(state["state"]), np.array(state["covariance"]))
        self.status, self.unseen = np.array(state["status"]), np.array(state["unseen"])
        self.last, self.before = np.array(state["last"]), np.array(state["before"])
        self.time, self.period = int(state["time"]), float(state["period"])

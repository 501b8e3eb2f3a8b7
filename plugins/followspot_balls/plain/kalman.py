"""Kalman filters and the missing-frame counter, and nothing more (Jin & Qian 2008, sections 3.7 and 3.8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.tracking import LOST, MISSING, TRACKED, Forecast, Positions, Tracks
from followspot_balls.filtering.motion import Motion, initiated, predict, update

DEFAULT_PERIOD = 1 / 30
"""Frame interval before the second frame, s."""


@dataclass(frozen=True)
class Outputs:
    """The measured targets, and the forecast of all for the next frame."""

    tracks: Tracks
    forecast: Forecast


class PlainKalman(Stage):
    """Filter each target with a first-order motion model; count the frames in which it is missing.

    A target that is not measured is missing: it is sought at its last position. When its counter reaches the
    threshold it is lost, and only a position with a pair of a colour and an infrared camera recovers it.
    """

    advice = "a colour and an infrared camera must see a target at once before it is tracked"

    class Params(StageParams):
        acceleration_sigma: float = Field(
            12.0,
            gt=0,
            unit="m/s^2",
            description="sigma of the acceleration; raising it follows turns faster and smooths less",
        )
        measurement_sigma: float = Field(
            0.008, gt=0, unit="m", description="sigma of a measured position; raising it smooths more"
        )
        initial_velocity_sigma: float = Field(
            3.0,
            gt=0,
            unit="m/s",
            description="sigma of a new target's velocity; raising it catches faster targets",
        )
        maximum_missed_frames: int = Field(
            25,
            ge=1,
            unit="frames",
            description="value of the missing-frame counter (M_TH) at which a target is lost; raising it "
            "searches longer at the last position",
        )

    params: Params

    def setup(self) -> None:
        """Begin with every target lost."""
        count = len(self.room.targets)
        self.motion = Motion.zero(count)
        self.status = np.full(count, LOST, np.uint8)
        self.missed = np.zeros(count, int)
        self.last, self.before = np.zeros((2, count, 3))
        self.time, self.period = -1, DEFAULT_PERIOD

    def process(self, positions: Positions) -> Outputs:
        p = self.params
        if 0 <= self.time < positions.header.time:
            self.period = (positions.header.time - self.time) * NANOSECOND
        self.time = positions.header.time
        known = np.isfinite(positions.xyz).all(axis=1)
        positions = positions.where(known & (positions.confirmed | (self.status[positions.target] != LOST)))
        target, xyz = positions.target.astype(np.intp), positions.xyz
        new = self.status[target] == LOST
        noise = np.tile(np.eye(3) * p.measurement_sigma**2, (len(target), 1, 1))
        motion = predict(self.motion, self.period, p.acceleration_sigma)
        motion = initiated(motion, target[new], xyz[new], noise[new], p.initial_velocity_sigma)
        self.motion, _ = update(motion, target[~new], xyz[~new], noise[~new])
        self.count(target)
        self.remember(target, target[new])
        return Outputs(self.tracks(), self.forecast())

    def count(self, target: Array) -> None:
        """Advance the missing-frame counters of targets other than `target`, which were measured."""
        known = self.status != LOST
        self.missed = (self.missed + 1) * known
        self.missed[target] = 0
        lasting = known & (self.missed < self.params.maximum_missed_frames)
        self.status = np.where(lasting, MISSING, LOST).astype(np.uint8)
        self.status[target] = TRACKED

    def remember(self, target: Array, new: Array) -> None:
        """Store the last two estimates of measured targets; missing ones rest at the last."""
        self.before[target] = self.last[target]
        self.last[target] = self.motion.xyz[target]
        self.before[new] = self.last[new]
        missing = self.status == MISSING
        self.motion.state[missing, :3], self.motion.state[missing, 3:] = self.last[missing], 0.0

    def tracks(self) -> Tracks:
        """Rows of the targets that were measured in this frame."""
        target = np.flatnonzero(self.status == TRACKED)
        return Tracks(
            target=target.astype(np.int32),
            state=self.status[target],
            xyz=self.motion.xyz[target],
            velocity=self.motion.velocity[target],
            sigma=self.motion.sigma[target],
        )

    def forecast(self) -> Forecast:
        """The targets one period later; the rows of lost targets are zero."""
        ahead = predict(self.motion, self.period, self.params.acceleration_sigma)
        keep = (self.status != LOST)[:, None]
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
        own = {"status": self.status, "missed": self.missed, "last": self.last, "before": self.before}
        return {**self.motion._asdict(), **own, "time": self.time, "period": self.period}

    def restore(self, state: Any) -> None:
        self.motion = Motion(*(np.array(state[name]) for name in Motion._fields))
        self.status, self.missed = np.array(state["status"], np.uint8), np.array(state["missed"])
        self.last, self.before = np.array(state["last"]), np.array(state["before"])
        self.time, self.period = int(state["time"]), float(state["period"])

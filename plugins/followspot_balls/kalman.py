"""Smoothing, forecast and life cycle of targets (Jin & Qian 2008, sections 3.7 and 3.8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.tracking import LOST, MISSING, PREDICTED, TRACKED, Forecast, Positions, Tracks
from followspot_balls.life_cycle import Evidence, LifeCycle, aged, believed, sought
from followspot_balls.motion import Motion, followed, predict, started

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
        gate: float = Field(
            3.0,
            gt=0,
            unit="1",
            description="sigmas from the forecast at which a measurement means that the target bounced or "
            "was hit; raising it smooths more and follows later",
        )
        missing: int = Field(
            25,
            ge=0,
            unit="frames",
            description="frames for which a target that is not seen, or by one camera only, is sought near "
            "its last place",
        )
        near: int = Field(
            4,
            ge=0,
            unit="frames",
            description="frames of these for which it is sought there only; then, in every second frame, "
            "everywhere, as if it were lost; raising it finds those later that come back elsewhere",
        )
        vague: float = Field(
            0.1,
            gt=0,
            unit="m",
            description="one sigma beyond which a target that one camera sees is missing; raising it bridges "
            "longer gaps, and may follow something else",
        )
        support: int = Field(
            3,
            ge=1,
            unit="1",
            description="candidates that must agree for a target that is not tracked to be believed at once, "
            "or for one that is to have bounced; raising it avoids false recoveries",
        )
        frames: int = Field(
            3,
            ge=1,
            unit="frames",
            description="frames that must show an evident candidate of a target that is not tracked; "
            "raising it avoids false recoveries and delays true ones",
        )
        reach: float = Field(
            0.3, gt=0, unit="m", description="farthest that these frames may lie from one to the next"
        )
        fade: float = Field(
            0.1,
            ge=0,
            unit="s",
            description="time in which the velocity of a target fades that is not measured; 0: a missing one "
            "stays at its last place",
        )
        speed: float = Field(3.0, gt=0, unit="m/s", description="one sigma of the velocity of a new target")

    params: Params

    def setup(self) -> None:
        count = len(self.room.targets)
        p = self.params
        apart = min((t.radius for t in self.room.targets.values()), default=0.0)
        self.evidence = Evidence(p.support, p.frames, p.reach, apart)
        self.constant = np.eye(3) * p.measurement**2
        self.motion = Motion.zero(count)
        self.life = LifeCycle.lost(count)
        self.last, self.before = np.zeros((count, 3)), np.zeros((count, 3))
        self.time, self.period = -1, DEFAULT_PERIOD

    def process(self, positions: Positions) -> Outputs:
        p = self.params
        self.advance(positions.header.time)
        status = sought(self.life, p.near)
        life, counted = believed(self.life, status, p.near, positions, self.evidence)
        if not counted.all():
            positions = positions.where(counted)
        target, xyz = positions.target.astype(np.intp), positions.xyz
        noise, sure = self.noise(positions.covariance), positions.support >= p.support
        motion = predict(self.motion, self.period, p.acceleration)
        new = status.take(target) == LOST
        old = slice(None)
        if new.any():
            motion = started(motion, target[new], xyz[new], noise[new], p.speed)
            old = ~new
        self.motion = followed(motion, target[old], xyz[old], noise[old], sure[old], self.period, p.gate)
        measured, bridged = np.zeros((2, len(life.status)), bool)
        measured[target] = ~positions.predicted
        if positions.predicted.any():
            vague = self.motion.sigma.take(target, axis=0).max(axis=1) > p.vague
            bridged[target] = positions.predicted & ~vague
        self.life = aged(life, measured, bridged, p.missing)
        self.remember(target, target[new])
        return Outputs(self.tracks(), self.forecast())

    def advance(self, time: int) -> None:
        """Measure the period from capture times, ns; frame intervals may vary."""
        if self.time >= 0 and time > self.time:
            self.period = (time - self.time) * NANOSECOND
        self.time = time

    def noise(self, covariance: Array) -> Array:
        """Covariances of measurements, with the constant one where the fusion knows none."""
        return np.where(np.isfinite(covariance), covariance, self.constant)

    def remember(self, target: Array, new: Array) -> None:
        """Keep the last two estimates of measured targets; let those that were not measured come to rest."""
        self.before[target] = self.last.take(target, axis=0)
        self.last[target] = self.motion.xyz.take(target, axis=0)
        self.before[new] = self.last[new]
        status = self.life.status
        if self.params.fade > 0:
            unmeasured = ((status == MISSING) | (status == PREDICTED)).nonzero()[0]
            self.motion.state[unmeasured, 3:] *= np.exp(-self.period / self.params.fade)
        else:
            missing = (status == MISSING).nonzero()[0]
            self.motion.state[missing, :3], self.motion.state[missing, 3:] = self.last[missing], 0.0

    def tracks(self) -> Tracks:
        """Rows of the targets that were measured in this frame, or at least seen once."""
        target = ((self.life.status == TRACKED) | (self.life.status == PREDICTED)).nonzero()[0]
        return Tracks(
            target=target.astype(np.int32),
            state=self.life.status.take(target),
            xyz=self.motion.xyz.take(target, axis=0),
            velocity=self.motion.velocity.take(target, axis=0),
            sigma=self.motion.sigma.take(target, axis=0),
        )

    def forecast(self) -> Forecast:
        """Where the targets will be one period from now; the rows of lost ones are zero."""
        status = sought(self.life, self.params.near)
        known = status != LOST
        ahead = predict(self.motion, self.period, self.params.acceleration)
        keep = known[:, None]
        return Forecast(
            period=self.period,
            state=status,
            xyz=ahead.xyz * keep,
            velocity=ahead.velocity * keep,
            covariance=ahead.covariance[:, :3, :3] * keep[..., None],
            last=self.last * keep,
            before=self.before * keep,
        )

    def state(self) -> Any:
        return {
            **self.motion._asdict(),
            **self.life._asdict(),
            "last": self.last,
            "before": self.before,
            "time": self.time,
            "period": self.period,
        }

    def restore(self, state: Any) -> None:
        self.motion = Motion(*(np.array(state[name]) for name in Motion._fields))
        self.life = LifeCycle(*(np.array(state[name]) for name in LifeCycle._fields))
        self.last, self.before = np.array(state["last"]), np.array(state["before"])
        self.time, self.period = int(state["time"]), float(state["period"])

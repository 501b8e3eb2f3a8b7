"""The Kalman filter of targets with first-order motion (Jin & Qian 2008, section 3.7)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from followspot import Array
from followspot_balls.filtering.motion import Motion, followed, initiated, predict, slowed
from followspot_target_filter.manoeuvre import Bounces, ManoeuvreParams
from followspot_target_filter.motion_model import Estimate
from followspot_target_filter.stage import TargetFilter


class Kalman(TargetFilter):
    """Filter each target with a first-order motion model; keep its life cycle: tracked, missing, lost."""

    class Params(TargetFilter.Params, ManoeuvreParams):
        """The life cycle and the motion model."""

    params: Params

    def motion_model(self, count: int) -> ConstantVelocity:
        """Constant velocity, disturbed by accelerations and bounces."""
        p = self.params
        return ConstantVelocity(count, p.acceleration_sigma, p.bounces)


class ConstantVelocity:
    """First-order motion of all targets at once, which random accelerations and bounces disturb.

    acceleration: one sigma, m/s^2. The velocity of a new target is as unknown as that after a bounce.
    """

    def __init__(self, count: int, acceleration: float, bounces: Bounces) -> None:
        self.acceleration = acceleration
        self.bounces = bounces
        self.motion = Motion.zero(count)

    @property
    def estimate(self) -> Estimate:
        return _estimate(self.motion)

    def predict(self, seconds: float) -> None:
        self.motion = predict(self.motion, seconds, self.acceleration)

    def ahead(self, seconds: float) -> Estimate:
        return _estimate(predict(self.motion, seconds, self.acceleration))

    def initiate(self, target: Array, xyz: Array, noise: Array) -> None:
        self.motion = initiated(self.motion, target, xyz, noise, self.bounces.speed)

    def update(self, target: Array, xyz: Array, noise: Array, sure: Array, seconds: float) -> None:
        self.motion = followed(self.motion, target, xyz, noise, sure, seconds, self.bounces)

    def slow(self, target: Array, factor: float) -> None:
        self.motion = slowed(self.motion, target, factor)

    def stop(self, target: Array, xyz: Array) -> None:
        self.motion.state[target, :3], self.motion.state[target, 3:] = xyz, 0.0

    def state(self) -> Mapping[str, Array]:
        return self.motion._asdict()

    def restore(self, state: Mapping[str, Array]) -> None:
        self.motion = Motion(*(np.array(state[name]) for name in Motion._fields))


def _estimate(motion: Motion) -> Estimate:
    return Estimate(motion.xyz, motion.velocity, motion.covariance[:, :3, :3])

"""The Kalman filter of targets with first-order motion (Jin & Qian 2008, section 3.7)."""

from __future__ import annotations

from followspot_balls.constant_velocity import ConstantVelocity
from followspot_target_filter.manoeuvre import ManoeuvreParams
from followspot_target_filter.stage import TargetFilter


class Kalman(TargetFilter):
    """Filter each target with a first-order motion model; keep its life cycle: tracked, missing, lost."""

    class Params(TargetFilter.Params, ManoeuvreParams):
        """The life cycle and the motion model."""

    params: Params

    def motion_model(self, count: int) -> ConstantVelocity:
        """Constant velocity, disturbed by accelerations and bounces."""
        p = self.params
        return ConstantVelocity(count, p.acceleration_sigma, p.bounce_gate, p.initial_velocity_sigma)

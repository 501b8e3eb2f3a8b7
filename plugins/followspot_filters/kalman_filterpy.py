"""Stage `filters.kalman_filterpy`: targets filtered by the package filterpy."""

from __future__ import annotations

from typing import Literal

from followspot import Field
from followspot_filters.bank import Bank, TargetEstimator
from followspot_filters.interacting import InteractingModels
from followspot_filters.models import ConstantAcceleration, ConstantVelocity, Forgetful
from followspot_filters.single import SingleModel
from followspot_target_filter.manoeuvre import ManoeuvreParams
from followspot_target_filter.motion_model import MotionModel
from followspot_target_filter.stage import TargetFilter


class KalmanFilterpy(TargetFilter):
    """Filter each target with a motion model of the package filterpy, with the life cycle of `balls.kalman`.

    With `constant_velocity` it computes what `balls.kalman` computes, target by target. `imm` weighs constant
    velocity, constant acceleration and a bounce by how well each foretells the measurements.
    """

    class Params(TargetFilter.Params, ManoeuvreParams):
        """The life cycle and the motion models."""

        model: Literal["constant_velocity", "constant_acceleration", "imm"] = Field(
            "constant_velocity", description="model of motion; imm uses both and a bounce"
        )
        jerk_sigma: float = Field(
            200.0,
            gt=0,
            unit="m/s^3",
            description="sigma of the jerk (constant_acceleration, imm); raising it follows turns faster",
        )
        initial_acceleration_sigma: float = Field(
            10.0,
            gt=0,
            unit="m/s^2",
            description="sigma of a new target's acceleration; raising it catches tosses faster",
        )
        bounce_speed_sigma: float = Field(
            3.0,
            gt=0,
            unit="m/s",
            description="sigma of a bounce's change of velocity (imm); raising it follows harder bounces",
        )

    params: Params

    def motion_model(self, count: int) -> MotionModel:
        """A filter for each target."""
        return Bank(count, self.estimator, self.params.model, self.params.initial_velocity_sigma)

    def estimator(self) -> TargetEstimator:
        """The filter of one target."""
        p = self.params
        steady, tossed = ConstantVelocity(p.acceleration_sigma), ConstantAcceleration(p.jerk_sigma)
        initial = p.initial_acceleration_sigma
        if p.model == "constant_velocity":
            return SingleModel(steady, p.bounces, initial)
        if p.model == "constant_acceleration":
            return SingleModel(tossed, p.bounces, initial)
        bounced = Forgetful(steady, initial, p.bounce_speed_sigma)
        return InteractingModels([Forgetful(steady, initial), tossed, bounced], initial)

"""Positions of targets that only one camera sees, marked as predicted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from followspot import Array, Field, Joined, Latest, Stage
from followspot.tracking import Blobs, ExistenceOdds, Forecast, Positions
from followspot_balls.association.color_views import ColorViews
from followspot_balls.association.infrared_only import Colorless, ColorlessParams
from followspot_balls.filtering.predicted_positions import with_predicted
from followspot_balls.measurement.outline import unit_outline
from followspot_balls.pairs.time_alignment import delays
from followspot_balls.scene.targets import lost_targets, target_radii, tracked_targets
from followspot_balls.single_view.position import (
    MAXIMUM_DEVIATION,
    RISING_SPEED,
    BallStates,
    Innovations,
    most_likely_positions,
    normalized_squares,
    projections,
    supporting_planes,
)
from followspot_balls.single_view.steady_motion import SteadyMotion


class Bridge(Stage):
    """Add targets that the fusion could not place: from a single view and the forecast, or a plane.

    The added positions are marked as predicted. The stage adds none of a target that the association has
    given up (`existence`), or that no colour camera has shown for `colorless_time`. It leaves out positions
    that a single weak pair shows far from the forecast (`single_pair_gate`).
    """

    class Params(ColorlessParams):
        gate: float = Field(
            3.0,
            gt=0,
            unit="sigma",
            description="largest distance between the forecast and a blob that is taken for the target; "
            "raising it survives turns",
        )
        blob_sigma: float = Field(
            0.7, gt=0, unit="px", description="sigma of a blob's centre; raising it trusts blobs less"
        )
        minimum_area: float = Field(
            0.2,
            ge=0,
            unit="1",
            description="smallest area of a blob over the target's expected area; raising it bridges less",
        )
        maximum_area: float = Field(
            1.6,
            gt=0,
            unit="1",
            description="largest area of a blob over the target's expected area; raising it bridges more",
        )
        single_pair_sigma: float = Field(
            0.01,
            gt=0,
            unit="m",
            description="sigma of a position from a single pair; raising it trusts it more",
        )
        single_pair_gate: float = Field(
            3.0,
            gt=0,
            unit="sigma",
            description="largest distance between the forecast and a position from a single weak pair; a "
            "position farther away is left out, and the stage uses a single view instead; raising it lets "
            "targets jump",
        )
        resting_clearance: float = Field(
            0.03,
            ge=0,
            unit="m",
            description="largest clearance above a plane of a target that lies on the plane, unless it "
            "rises; 0: no target lies on a plane; raising it bridges more",
        )

    params: Params

    def setup(self) -> None:
        cameras = self.room.cameras.values()
        self.number = {name: i for i, name in enumerate(self.room.cameras)}
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.centers = np.array([c.center for c in cameras]).reshape(-1, 1, 3)
        self.clock_offset = np.array([c.clock_offset for c in cameras])
        self.planes = np.array(list(self.room.planes.values())).reshape(-1, 4)
        self.radius = target_radii(self.room)
        self.outline = unit_outline(self.room)
        self.steady = SteadyMotion.unknown(len(self.radius))
        self.color = ColorViews(self.room)
        self.colorless = Colorless(self.room, self.params)

    def process(
        self,
        positions: Positions,
        blobs: Joined[Blobs],
        forecast: Latest[Forecast] = None,
        existence: Joined[ExistenceOdds] = (),
    ) -> Positions:
        tracked = tracked_targets(forecast, len(self.radius))
        if forecast is None or not len(forecast.xyz):
            return positions
        before, self.steady = self.steady, self.steady.updated(forecast.xyz, tracked, forecast.period)
        if not np.count_nonzero(tracked):
            return positions
        rejected = tracked[positions.target] & self.outside_gate(positions, forecast)
        if np.count_nonzero(rejected):
            positions = positions.where(~rejected)
        too_long = self.colorless_too_long(tracked, positions, blobs, forecast)
        unmeasured = tracked.copy()
        unmeasured[positions.target] &= (positions.support == 0) & ~positions.evident
        for one in existence:
            unmeasured &= ~one.given_up
        if not np.count_nonzero(unmeasured) or not any(len(b.xy) for b in blobs):
            return positions
        target = np.flatnonzero(unmeasured)
        innovations, found = self.nearest_blobs(target, blobs, forecast)
        found &= ~too_long[target]
        target = target[found]
        predicted = self.single_view_positions(target, innovations.where(found), forecast, before)
        return with_predicted(positions, *predicted)

    def single_view_positions(
        self, target: Array, innovations: Innovations, forecast: Forecast, motion: SteadyMotion
    ) -> tuple[Array, Array, Array]:
        """Targets with a position from one view, these positions (M, 3) m and covariances (M, 3, 3) m^2.

        If a ball rolled along a plane and is now far from where its steady motion would have taken it, it was
        picked up or pushed, and may be anywhere on the ray: it gets no position.
        target: (M,); innovations: of M blobs; motion: before this frame.
        """
        radius, reach, sigma = self.radius[target], self.params.resting_clearance, self.params.blob_sigma
        ball = BallStates(forecast.xyz[target], forecast.velocity[target], forecast.covariance[target])
        steady = BallStates(motion.xyz[target], motion.velocity[target], np.zeros((len(target), 3, 3)))
        support = supporting_planes(ball, radius, self.planes, reach)
        normal, _ = supporting_planes(steady, radius, self.planes, reach)
        landed = np.vecdot(steady.velocity, normal) >= -RISING_SPEED
        rolled = support[0].any(axis=1) & normal.any(axis=1) & landed
        xyz, covariance = most_likely_positions(ball.xyz, innovations, support, sigma)
        deviation = np.linalg.norm(motion.deviation(xyz, target, forecast.period), axis=1)
        near = ~rolled | (deviation <= MAXIMUM_DEVIATION)
        return target[near], xyz[near], covariance[near]

    def colorless_too_long(
        self, tracked: Array, positions: Positions, blobs: Sequence[Blobs], forecast: Forecast
    ) -> Array:
        """Which tracked targets no colour camera has shown for too long: (T,) bool. tracked: (T,) bool."""
        too_long = np.zeros(len(tracked), bool)
        if not self.colorless.applies:
            return too_long
        target, unconfirmed = tracked.nonzero()[0], tracked.copy()
        unconfirmed[positions.target[positions.confirmed]] = False
        shown = ~unconfirmed
        if np.count_nonzero(unconfirmed):
            shown |= self.color.shown(forecast.xyz, blobs).diagonal()
        xyz = forecast.xyz.take(target, axis=0)
        too_long[target] = self.colorless.unshown_too_long(target, shown[target], xyz, forecast.period)
        return too_long

    def state(self) -> Any:
        return {**self.steady._asdict(), "since": self.colorless.since}

    def restore(self, state: Any) -> None:
        self.steady = SteadyMotion(*(np.array(state[name]) for name in SteadyMotion._fields))
        self.colorless.since = np.array(state["since"], float)

    def outside_gate(self, positions: Positions, forecast: Forecast) -> Array:
        """Which positions lie far from the forecast and have no pair, or one weak pair: (M,) bool."""
        weak = positions.support + positions.evident < 2
        if not np.count_nonzero(weak):
            return weak
        single = self.params.single_pair_sigma**2 * np.eye(3)
        known = np.where(np.isfinite(positions.covariance), positions.covariance, single)
        spread = forecast.covariance[positions.target] + known
        offset = positions.xyz - forecast.xyz[positions.target]
        return np.asarray(weak & (_squared_mahalanobis(offset, spread) > self.params.single_pair_gate**2))

    def nearest_blobs(
        self, target: Array, blobs: Sequence[Blobs], forecast: Forecast
    ) -> tuple[Innovations, Array]:
        """The blob of all views that is nearest to the forecast of each target; whether it passes the gate.

        target: (M,) numbers. Returns the innovations of M blobs, and (M,) bool.
        """
        number = np.array([self.number[b.camera] for b in blobs])
        delay = np.zeros(len(self.P))
        delay[number] = delays(blobs, self.clock_offset[number])
        xyz = forecast.xyz + delay[:, None, None] * forecast.velocity
        pixel, jacobian = projections(self.P, xyz)
        view = np.repeat(number, [len(b.xy) for b in blobs])
        measured = np.concatenate([b.xy for b in blobs])[:, None]
        innovations = Innovations(measured - pixel[view], jacobian[view])
        compatible = self.compatible(innovations.offset, view, blobs, forecast)
        distance = normalized_squares(innovations, forecast.covariance, self.params.blob_sigma)
        distance = np.where(compatible, distance, np.inf)
        blob = distance[:, target].argmin(axis=0)
        return innovations.where((blob, target)), distance[blob, target] <= self.params.gate**2

    def compatible(self, offset: Array, view: Array, blobs: Sequence[Blobs], forecast: Forecast) -> Array:
        """Which of N blobs fit which of T targets: the size fits, and no other target is nearer: (N, T) bool.

        offset: (N, T, 2) px from the projections of the forecasts; view: (N,).
        """
        away = forecast.xyz - self.centers
        outline = self.outline[:, None] * self.radius**2 / np.vecdot(away, away)
        share = np.concatenate([b.area for b in blobs])[:, None] / outline[view]
        allowed = np.concatenate([b.targets for b in blobs]) & ~lost_targets(forecast, len(self.radius))
        distance = np.where(allowed, np.hypot(offset[..., 0], offset[..., 1]), np.inf)
        own = distance <= distance.min(axis=1, keepdims=True, initial=np.inf)
        fits = (share >= self.params.minimum_area) & (share <= self.params.maximum_area)
        return np.asarray(allowed & own & fits)


def _squared_mahalanobis(offset: Array, spread: Array) -> Array:
    """Squared Mahalanobis distance: (M, 3), (M, 3, 3) -> (M,). A singular covariance gives inf."""
    try:
        distance: Array = np.vecdot(offset, np.linalg.solve(spread, offset[..., None])[..., 0])
    except np.linalg.LinAlgError:
        return np.full(len(offset), np.inf)
    return distance

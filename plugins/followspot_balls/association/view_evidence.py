"""Evidence of the blobs of all cameras of a room for hypotheses about positions of targets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Candidates, Forecast
from followspot_balls.association.hypotheses import Hypotheses, gauss_newton_step, jacobians
from followspot_balls.association.likelihood import (
    BallModel,
    BlobResiduals,
    LikeliestBlobs,
    ball_densities,
    likeliest_blobs,
    precision,
    view_log_ratios,
)
from followspot_balls.association.view_params import ViewParams
from followspot_balls.measurement.blob_table import BlobTable, blob_table
from followspot_balls.measurement.center_precision import Outlines
from followspot_balls.measurement.points import Images, point_images
from followspot_balls.scene.targets import target_radii

NEAREST = 1e-3
"""Smallest depth of a position that has an image, m."""
SMALLEST = 0.008
"""Radius of a ball's image, over the longer side of the picture, below which the density of false blobs no
longer grows. With a smaller radius, a fixed number of them in its square would be hundreds in the picture,
and two views that agree about a small ball could never outweigh them."""
STEPS = 2
"""Gauss-Newton steps of a position."""


class HypothesisViews(NamedTuple):
    """The likelihoods of M hypotheses in C views."""

    blobs: LikeliestBlobs
    in_picture: Array
    """(M, C) bool, whether the picture contains the position."""
    log_ratio: Array
    """(M, C) log-likelihood ratios."""
    jacobian: Array
    """(M, C, 2, 3) px/m, of the projections by the positions."""
    residual: Array
    """(M, C, 2) px, the likeliest blobs minus the projections."""

    def where(self, rows: Array) -> HypothesisViews:
        """Those of some hypotheses."""
        blobs, *others = self
        return HypothesisViews(
            LikeliestBlobs(*(column[rows] for column in blobs)), *(column[rows] for column in others)
        )


class FrameBlobs(NamedTuple):
    """The blobs of one frame."""

    table: BlobTable
    """The blobs of C cameras, up to K in each."""
    unit_area: Array
    """(C, K) areas over that of a ball of unit radius at unit depth."""
    rival_density: Array
    """(T, C, K) 1/px^2, density of each blob as an image of all targets except one, for each target."""


class ViewEvidence:
    """Computes the likelihoods of hypotheses from the blobs of the cameras of a room."""

    def __init__(self, room: Room, params: ViewParams, remembering: bool = False) -> None:
        """remembering: whether clutter is rarer at places where a view has shown no blobs of lost targets."""
        p, cameras = params, list(room.cameras.values())
        self.model = BallModel(
            p.detection,
            p.clutter,
            p.neighbourhood,
            p.blob_sigma,
            p.relative_sigma,
            p.hidden_sigma,
            SMALLEST * np.array([max(c.size) for c in cameras], float),
        )
        self.remembering = remembering
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.focal = np.array([c.matrix[0, 0] for c in cameras])
        self.pictures = Views(cameras)
        self.radii = target_radii(room)
        self.outlines = Outlines(room)

    def blobs(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> FrameBlobs:
        """The blobs of N > 0 candidates. tracked: (T,) bool."""
        table = blob_table(candidates, len(self.P))
        if not self.remembering:
            table = table._replace(clutter_ratio=np.ones(table.area.shape))
        unit_area = self.outlines.at_unit_depth(table.xy, table.area)
        blobs = FrameBlobs(table, unit_area, np.zeros((len(self.radii), *table.area.shape)))
        if forecast is None or not tracked.any() or len(self.radii) < 2:
            return blobs
        return blobs._replace(rival_density=self.rival_density(blobs, forecast, tracked))

    def rival_density(self, blobs: FrameBlobs, forecast: Forecast, tracked: Array) -> Array:
        """Density of each blob as an image of all forecasts except that of each target: (T, C, K) 1/px^2."""
        residuals, projected = self.residuals(forecast.xyz, np.arange(len(self.radii)), blobs)
        variance = forecast.covariance.diagonal(axis1=1, axis2=2).mean(axis=1)[:, None]
        spread = variance * np.square(self.focal / projected.depth)
        density, _ = ball_densities(self.model, residuals, spread[..., None])
        density *= self.model.detection * tracked[:, None, None]
        return np.asarray(density.sum(axis=0) - density)

    def residuals(self, xyz: Array, target: Array, blobs: FrameBlobs) -> tuple[BlobResiduals, Images]:
        """The blobs compared with the projections of targets (M,) at positions (M, 3) m; the projections."""
        table, projected = blobs.table, point_images(self.P, xyz)
        right = table.xy[..., 0] - projected.xy[..., 0, None]
        down = table.xy[..., 1] - projected.xy[..., 1, None]
        depth, radius = np.maximum(projected.depth, NEAREST), self.radii[target][:, None]
        residuals = BlobResiduals(
            squared_distance=right * right + down * down,
            area_ratio=blobs.unit_area * np.square(depth / radius)[..., None],
            radius=self.focal * radius / depth,
            compatible=table.targets[target],
            in_picture=self.pictures.in_pictures(xyz).T & (depth > NEAREST),
            clutter_ratio=table.clutter_ratio,
        )
        return residuals, Images(projected.xy, depth)

    def views(self, found: Hypotheses, blobs: FrameBlobs, detection: Array) -> HypothesisViews:
        """The likelihoods of the hypotheses. detection: (T, C) probabilities that views detect targets."""
        residuals, projected = self.residuals(found.xyz, found.target, blobs)
        likeliest = likeliest_blobs(self.model, residuals, blobs.rival_density[found.target])
        log_ratio = view_log_ratios(detection[found.target], likeliest, residuals.in_picture)
        residual = blobs.table.xy[np.arange(len(self.P)), likeliest.slot] - projected.xy
        jacobian = jacobians(self.P, projected.xy, projected.depth)
        return HypothesisViews(likeliest, residuals.in_picture, log_ratio, jacobian, residual)

    def likeliest(
        self, found: Hypotheses, blobs: FrameBlobs, detection: Array
    ) -> tuple[Hypotheses, HypothesisViews]:
        """The hypotheses at their likeliest positions, and their views; detection as for :meth:`views`."""
        return self.refined(found, self.views(found, blobs, detection), blobs, detection)

    def refined(
        self, found: Hypotheses, views: HypothesisViews, blobs: FrameBlobs, detection: Array
    ) -> tuple[Hypotheses, HypothesisViews]:
        """As :meth:`likeliest`, from the views of the hypotheses as they are."""
        for _ in range(STEPS):
            weight = precision(views.blobs, views.log_ratio)
            step = gauss_newton_step(found, views.jacobian, views.residual, weight)
            found = found.moved(found.xyz + step)
            views = self.views(found, blobs, detection)
        return found, views

"""What the blobs of all cameras of a room say about places of targets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Candidates, Forecast
from followspot_balls.association.hypotheses import Hypotheses, jacobians, step
from followspot_balls.association.likelihood import (
    BallModel,
    Likely,
    Sight,
    densities,
    likeliest,
    precision,
    view_ratios,
)
from followspot_balls.association.view_params import ViewParams
from followspot_balls.measurement.blob_table import Sightings, sightings
from followspot_balls.measurement.center_precision import Outlines
from followspot_balls.measurement.points import Images, point_images
from followspot_balls.scene.targets import target_radii

NEAREST = 1e-3
"""Smallest depth of a place that has an image, m."""
SMALLEST = 0.008
"""Radius of a ball's image over the longer side of the picture below which false blobs are no denser. Where
the radius is smaller, a fixed number in its square would be hundreds in the picture: two views that agree
about a small ball could never outweigh them."""
STEPS = 2
"""Gauss-Newton steps of a place."""


class PlaceViews(NamedTuple):
    """M places as C views show them."""

    likely: Likely
    """The likeliest blobs."""
    inside: Array
    """(M, C) bool, whether the picture contains the place."""
    ratio: Array
    """(M, C) log-likelihood ratios."""
    jacobian: Array
    """(M, C, 2, 3) px/m, of the images by the places."""
    error: Array
    """(M, C, 2) px, of the likeliest blobs from the images."""

    def where(self, rows: Array) -> PlaceViews:
        """Those of some places."""
        likely, *others = self
        return PlaceViews(Likely(*(column[rows] for column in likely)), *(column[rows] for column in others))


class FrameBlobs(NamedTuple):
    """The blobs of one frame."""

    table: Sightings
    """The blobs of C cameras, up to K in each."""
    sizes: Array
    """(C, K) areas over that of a ball of unit radius at unit depth."""
    rivals: Array
    """(T, C, K) 1/px^2, densities of the blobs as targets other than each."""


class ViewEvidence:
    """The cameras of a room, which tell how balls show to them."""

    def __init__(self, room: Room, params: ViewParams, remembering: bool = False) -> None:
        """remembering: whether there is less clutter where a view showed nothing while a target was lost."""
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
        table = sightings(candidates, len(self.P))
        if not self.remembering:
            table = table._replace(clutter=np.ones(table.area.shape))
        sizes = self.outlines.at_unit_depth(table.xy, table.area)
        blobs = FrameBlobs(table, sizes, np.zeros((len(self.radii), *table.area.shape)))
        if forecast is None or not tracked.any() or len(self.radii) < 2:
            return blobs
        return blobs._replace(rivals=self.rivals(blobs, forecast, tracked))

    def rivals(self, blobs: FrameBlobs, forecast: Forecast, tracked: Array) -> Array:
        """Densities of blobs as targets other than each, where those are expected: (T, C, K) 1/px^2."""
        sight, seen = self.sight(forecast.xyz, np.arange(len(self.radii)), blobs)
        variance = forecast.covariance.diagonal(axis1=1, axis2=2).mean(axis=1)[:, None]
        spread = variance * np.square(self.focal / seen.depth)
        density, _ = densities(self.model, sight, spread[..., None])
        density *= self.model.detection * tracked[:, None, None]
        return np.asarray(density.sum(axis=0) - density)

    def sight(self, xyz: Array, target: Array, blobs: FrameBlobs) -> tuple[Sight, Images]:
        """The blobs as seen from places (M, 3) m of targets (M,), and the images of these."""
        table, seen = blobs.table, point_images(self.P, xyz)
        off = table.xy - seen.xy[:, :, None]
        depth, radius = np.maximum(seen.depth, NEAREST), self.radii[target][:, None]
        inside = self.pictures.in_pictures(xyz).T & (depth > NEAREST)
        share = blobs.sizes * np.square(depth / radius)[..., None]
        size, possible = self.focal * radius / depth, table.targets[target]
        sight = Sight(np.vecdot(off, off), share, size, possible, inside, table.clutter)
        return sight, Images(seen.xy, depth)

    def views(self, found: Hypotheses, blobs: FrameBlobs, shown: Array) -> PlaceViews:
        """The places as the views show them. shown: (T, C), probabilities that they show the targets."""
        sight, seen = self.sight(found.xyz, found.target, blobs)
        likely = likeliest(self.model, sight, blobs.rivals[found.target])
        ratio = view_ratios(shown[found.target], likely, sight.inside)
        error = blobs.table.xy[np.arange(len(self.P)), likely.slot] - seen.xy
        return PlaceViews(likely, sight.inside, ratio, jacobians(self.P, seen.xy, seen.depth), error)

    def likeliest(self, found: Hypotheses, blobs: FrameBlobs, shown: Array) -> tuple[Hypotheses, PlaceViews]:
        """The hypotheses at their likeliest places, and their views; shown as for :meth:`views`."""
        return self.refined(found, self.views(found, blobs, shown), blobs, shown)

    def refined(
        self, found: Hypotheses, views: PlaceViews, blobs: FrameBlobs, shown: Array
    ) -> tuple[Hypotheses, PlaceViews]:
        """As :meth:`likeliest`, from the views of the hypotheses as they are."""
        for _ in range(STEPS):
            weight = precision(views.likely, views.ratio)
            found = found.moved(found.xyz + step(found, views.jacobian, views.error, weight))
            views = self.views(found, blobs, shown)
        return found, views

"""Covariance of a mode of candidates, from the errors of their blobs and from rival candidates.

The mode is the weighted mean of points, each triangulated of two blobs, so errors of a blob enter by all
candidates made of it: the covariance is the sum over views of s_v^2 G_v G_v^T, with the variance s_v^2 of the
view's ray across itself and the weighted sum G_v of what its displacement does to the view's candidates
(Hartley & Zisserman, section 5.2.6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Candidates
from followspot_balls.detection.strip import row_and_column
from followspot_balls.fusion.blob_params import BlobParams
from followspot_balls.fusion.modes import Modes
from followspot_balls.measurement.glow_shift import glow_sigma
from followspot_balls.measurement.outline import unit_outline
from followspot_balls.measurement.points import point_images
from followspot_balls.pairs.error_propagation import propagation
from followspot_balls.scene.targets import target_radii

UNLIKELY = 1e-8
"""Odds of rivals below which they are left out: 10 cm away they add 10 micrometres to a deviation."""
IDENTITY = np.eye(3)
TINY = np.finfo(float).tiny


class ModeViews(NamedTuple):
    """What the C cameras of a room contribute to M modes, each by one blob on average."""

    weight: Array
    """(M, C, C) share of the mode's weight that candidates of two cameras have; symmetric."""
    alone: Array
    """(M, C) share that single depth cameras have."""
    seen: Array
    """(M, C) bool, which have a blob."""
    area: Array
    """(M, C) px, its number of pixels."""
    squares: Array
    """(M, C) px^2, mean squared distance of the blob from the image of the mode."""


class ModeCovariance:
    """The covariances of modes in a room."""

    def __init__(self, room: Room, params: BlobParams, depth_sigma: float) -> None:
        cameras = list(room.cameras.values())
        self.params = params
        self.depth_variance = depth_sigma**2
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.centers = np.array([c.center for c in cameras]).reshape(-1, 3)
        self.focal2 = np.array([c.matrix[0, 0] for c in cameras]) ** 2
        self.color = np.flatnonzero([c.kind == "color" for c in cameras])
        self.depth = any(c.kind == "depth" for c in cameras)
        self.planes = np.array(list(room.planes.values())).reshape(-1, 4)
        self.normals = np.ascontiguousarray(self.planes[:, :3])
        self.radii = target_radii(room)
        self.outlines = np.square(self.radii)[:, None] * unit_outline(room)
        self.redundancy = params.prior_errors + np.maximum(2.0 * np.arange(len(cameras) + 1) - 3, 0)

    def of(self, candidates: Candidates, target: Array, center: Array, held: Array) -> Array:
        """Covariances (M, 3, 3) m^2 of the modes of targets (M,).

        center: (M, 3) m; held: (M, N) weights of the candidates in each mode, some above 0 in each row.
        """
        offset = center[:, None] - self.centers
        distance2 = np.vecdot(offset, offset)
        reach2 = distance2 / self.focal2
        views = self.views(candidates, center, held)
        gain = propagation(views.weight, offset / np.sqrt(distance2)[..., None], reach2)
        noise = self.params.center_variance(views.area * distance2 / self.outlines.take(target, axis=0))
        spread = gain * np.sqrt(reach2 * noise)[..., None, None]
        wide = spread.swapaxes(1, 2).reshape(len(center), 3, 3 * len(self.focal2))
        covariance = wide @ wide.swapaxes(1, 2) * self.misfit(views, noise)[:, None, None]
        self.add_glow(covariance, target, center, gain)
        if self.depth:
            alone = self.depth_variance * np.square(views.alone).sum(axis=1)
            covariance += alone[:, None, None] * IDENTITY
        return np.asarray(covariance)

    def precision(self, candidates: Candidates, target: Array) -> Array:
        """Precision of N candidates as places of targets (M,), over that of two blobs of whole balls: (M, N).

        The blobs' variances go by how much of the outlines they show; that of a depth camera alone is 1.
        """
        offset = candidates.xyz[:, None] - self.centers.take(candidates.view, axis=0)
        outline = self.outlines.take(target, axis=0).take(candidates.view, axis=1)
        noise = self.params.center_variance(candidates.area * np.vecdot(offset, offset) / outline)
        precision = 2 * self.params.blob_sigma**2 / (noise[..., 0] + noise[..., 1])  # as sum(axis=2), faster
        if self.depth:
            precision[:, candidates.view[:, 0] == candidates.view[:, 1]] = 1.0
        return np.asarray(precision)

    def views(self, candidates: Candidates, center: Array, held: Array) -> ModeViews:
        """What each camera contributes; several of its blobs in one mode count as their mean."""
        modes, cameras = len(center), len(self.focal2)
        entry = held.reshape(-1).nonzero()[0]
        mode, row = row_and_column(entry, held.shape[1])
        weight, view = held.take(entry), candidates.view.take(row, axis=0)
        at = (mode * cameras)[:, None] + view
        table = np.bincount(at[:, 0] * cameras + view[:, 1], weight, modes * cameras**2)
        table = table.reshape(modes, cameras, cameras)
        alone = table.diagonal(axis1=1, axis2=2)
        if self.depth:
            alone, weight = alone.copy(), weight * (view[:, 0] != view[:, 1])
            table.reshape(modes, cameras**2)[:, :: cameras + 1] = 0.0
        table = table + table.swapaxes(1, 2)
        of_view = table.sum(axis=2)
        total = (held.sum(axis=1) + TINY)[:, None]
        off = candidates.xy.take(row, axis=0) - point_images(self.P, center).xy.reshape(-1, 2).take(
            at, axis=0
        )
        area, squares = (
            np.bincount(at.reshape(-1), (each * weight[:, None]).reshape(-1), modes * cameras).reshape(
                of_view.shape
            )
            / (of_view + TINY)
            for each in (candidates.area.take(row, axis=0), np.vecdot(off, off))
        )
        return ModeViews(table / total[..., None], alone / total, of_view > 0, area, squares)

    def misfit(self, views: ModeViews, noise: Array) -> Array:
        """Factor of the variances from the errors themselves, (M,), as in `measurement.points.estimated`."""
        cost = (views.squares / noise).sum(axis=1)
        return np.asarray((self.params.prior_errors + cost) / self.redundancy.take(views.seen.sum(axis=1)))

    def add_glow(self, covariance: Array, target: Array, center: Array, gain: Array) -> None:
        """Add the shift by the light of balls on a plane, along its normal: all colour cameras share it.

        covariance: (M, 3, 3) m^2, changed; gain: (M, C, 3, 3), of :func:`propagation`.
        """
        p = self.params
        clearance = np.abs(center @ self.normals.T + self.planes[:, 3]) - self.radii.take(target)[:, None]
        least = clearance.min(axis=1, initial=np.inf)
        if not np.count_nonzero(least < p.glow_range):
            return
        sigma = glow_sigma(np.maximum(least, 0.0), p.glow_sigma, p.glow_range)  # 0 beyond the range
        nearest = clearance.argmin(axis=1)
        normal = self.normals.take(nearest, axis=0) * (np.sqrt(1 + p.glow_mean**2) * sigma)[:, None]
        shift = gain.take(self.color, axis=1).sum(axis=1) @ normal[..., None]
        covariance += shift * shift.swapaxes(1, 2)


def rivals_covariance(xyz: Array, center: Array, weights: Array, modes: Modes, exponent: float) -> Array:
    """What the possibility adds that candidates outside the modes show the balls: (M, 3, 3) m^2.

    It is their spread about the mode times its probability o^k / (h^k + o^k), with the weights h in the mode
    and o outside it, as in a mixture (Bar-Shalom, Li & Kirubarajan 2001, section 1.4.16).
    xyz: (N, 3) m; center: (M, 3) m; weights: (M, N); exponent: k.
    """
    total = np.maximum(weights.sum(axis=1) - modes.total, 0.0)
    odds = np.minimum(total / np.maximum(modes.total, TINY), 1e6) ** exponent
    covariance = np.zeros((len(center), 3, 3))
    likely = (odds >= UNLIKELY).nonzero()[0]
    if not len(likely):
        return covariance
    odds, total = odds.take(likely), total.take(likely)
    outside = weights.take(likely, axis=0) - modes.held.take(likely, axis=0)
    outside *= (odds / (1 + odds) / np.maximum(total, TINY))[:, None]
    offset = xyz - center.take(likely, axis=0)[:, None]
    covariance[likely] = (outside[..., None] * offset).swapaxes(1, 2) @ offset
    return covariance

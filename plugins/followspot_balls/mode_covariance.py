"""Covariance of a mode of candidates: what the errors of their blobs, and rival candidates, make of it.

A candidate is x = H^-1 (I_a x_a + I_b x_b) with H = I_a + I_b, where I_v = (f / d)^2 (1 - r r^T) is the
information of a view with unit noise at distance d along the ray r (triangulation for equal errors in angle).
The mode is their weighted mean, so errors of a blob enter by all candidates made of it: the covariance is the
sum over views of s_v^2 B_v I_v B_v, with B_v the weighted sum of H^-1 over the view's candidates (Hartley &
Zisserman, section 5.2.6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Candidates
from followspot_balls.blob_params import BlobParams
from followspot_balls.bundle.glow import glow_sigma, nearest_planes
from followspot_balls.bundle.points import point_images
from followspot_balls.bundle.trust import variance
from followspot_balls.outline import unit_outline

PARALLEL = 1e-6
"""Smallest squared sine of the angle between two rays."""
UNLIKELY = 1e-8
"""Odds of rivals below which they are left out: 10 cm away they add 10 micrometres to a deviation."""
IDENTITY = np.eye(3)
TINY = np.finfo(float).tiny


class Views(NamedTuple):
    """What the C cameras of a room contribute to M modes, each by one blob on average."""

    weight: Array
    """(M, C, C) share of the mode's weight that candidates of two cameras have; symmetric."""
    alone: Array
    """(M, C) share that single depth cameras have."""
    seen: Array
    """(M, C) bool, which have a blob."""
    area: Array
    """(M, C) px, its number of pixels."""
    xy: Array
    """(M, C, 2) px, undistorted."""
    scatter: Array
    """(M, C) px^2, mean squared norm of `xy`."""


class Rays(NamedTuple):
    """Where M modes are, as seen from C cameras."""

    unit: Array
    """(M, C, 3) towards the mode."""
    distance: Array
    """(M, C) m."""


class ModeCovariance:
    """The covariances of modes in a room."""

    def __init__(self, room: Room, params: BlobParams, depth_sigma: float) -> None:
        cameras = list(room.cameras.values())
        self.params = params
        self.depth_variance = depth_sigma**2
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.centers = np.array([c.center for c in cameras]).reshape(-1, 3)
        self.focal = np.array([c.matrix[0, 0] for c in cameras])
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.depth = any(c.kind == "depth" for c in cameras)
        self.different = 1.0 - np.eye(len(cameras))
        self.planes = np.array(list(room.planes.values())).reshape(-1, 4)
        self.radii = np.array([t.radius for t in room.targets.values()])
        self.outline = unit_outline(room)

    def of(self, candidates: Candidates, target: Array, center: Array, held: Array) -> Array:
        """Covariances (M, 3, 3) m^2 of the modes of targets (M,).

        center: (M, 3) m; held: (M, N) weights of the candidates in each mode, some above 0 in each row.
        """
        views = self.views(candidates, held)
        offset = center[:, None] - self.centers
        distance = np.sqrt(np.vecdot(offset, offset))
        rays = Rays(offset / distance[..., None], distance)
        focal = self.focal / distance
        gain = propagation(views.weight, rays.unit, np.square(focal))
        noise = self.noise(target, views, distance)
        spread = gain * (focal * np.sqrt(noise))[..., None, None]
        wide = spread.swapaxes(1, 2).reshape(len(center), 3, 3 * len(self.focal))
        covariance = wide @ wide.swapaxes(1, 2) * self.misfit(center, views, noise)[:, None, None]
        covariance += self.glow(target, center, gain, np.square(focal))
        if self.depth:
            alone = np.square(views.alone).sum(axis=1)
            covariance += self.depth_variance * alone[:, None, None] * IDENTITY
        return np.asarray(covariance)

    def views(self, candidates: Candidates, held: Array) -> Views:
        """What each camera contributes; several of its blobs in one mode count as their mean."""
        count, cameras = len(candidates.xyz), len(self.focal)
        row, view, xy = np.arange(count), candidates.view, candidates.xy
        blobs = np.empty((count, 2, 5))
        blobs[..., 0], blobs[..., 1], blobs[..., 2:4] = 1.0, candidates.area, xy
        blobs[..., 4] = np.vecdot(xy, xy)
        if self.depth:
            blobs[view[:, 0] == view[:, 1]] = 0.0
        table = np.zeros((count, cameras, cameras + 5))
        table[row, view[:, 0], view[:, 1]] = 1.0
        table[row, view[:, 0], cameras:] = blobs[:, 0]
        table[row, view[:, 1], cameras:] = blobs[:, 1]
        sums = held @ table.reshape(count, cameras * (cameras + 5))
        sums /= np.maximum(held.sum(axis=1), TINY)[:, None]
        sums = sums.reshape(len(held), cameras, cameras + 5)
        weight, blob = sums[..., :cameras], sums[..., cameras:]
        seen = blob[..., 0] > 0
        blob = blob / np.where(seen, blob[..., 0], 1.0)[..., None]
        single = weight.diagonal(axis1=1, axis2=2)
        weight = (weight + weight.swapaxes(1, 2)) * self.different
        return Views(weight, single, seen, blob[..., 1], blob[..., 2:4], blob[..., 4])

    def noise(self, target: Array, views: Views, distance: Array) -> Array:
        """Variances of the blobs' centres, (M, C) px^2, by the share of the outline that they show."""
        p = self.params
        share = views.area * np.square(distance / self.radii[target][:, None]) / self.outline
        return variance(share, p.blob_sigma, p.hidden_inflation, p.merged_inflation)

    def misfit(self, center: Array, views: Views, noise: Array) -> Array:
        """Factor of the variances from the errors themselves, (M,), as in `bundle.points.estimated`."""
        image = point_images(self.P, center).xy
        squares = views.scatter + np.vecdot(image, image - 2 * views.xy)
        cost = (np.maximum(squares, 0.0) / noise * views.seen).sum(axis=1)
        redundant = np.maximum(2 * views.seen.sum(axis=1) - 3, 0)
        prior = self.params.prior_errors
        return np.asarray((prior + cost) / (prior + redundant))

    def glow(self, target: Array, center: Array, gain: Array, information: Array) -> Array:
        """What the light of balls on a plane adds: all colour cameras share the shift along its normal.

        gain: (M, C, 3, 3) m^2, see :func:`propagation`; information: (M, C) 1/m^2. Returns (M, 3, 3) m^2.
        """
        p = self.params
        normal, clearance = nearest_planes(self.planes, center, self.radii[target])
        sigma = glow_sigma(clearance, p.glow_sigma, p.glow_range)
        if not sigma.any():
            return np.zeros((len(center), 3, 3))
        views = len(self.focal)
        total = (information * self.color)[:, None] @ gain.reshape(len(center), views, 9)
        shift = (total.reshape(len(center), 3, 3) @ normal[..., None]) * sigma[:, None, None]
        return np.asarray((1 + p.glow_mean**2) * shift * shift.swapaxes(1, 2))


def propagation(weight: Array, rays: Array, information: Array) -> Array:
    """B (1 - r r^T) of each view: the mode's shift for one of the ball across its ray, over the information.

    With rays a, b, their cosine c and information i, j, H^-1 is (1 + (i/j a a^T + c (a b^T + b a^T)
    + j/i b b^T) / (1 - c^2)) / (i + j), which needs no inversion of matrices.
    weight: (M, C, C); rays: (M, C, 3), unit vectors; information: (M, C) 1/m^2. Returns (M, C, 3, 3) m^2.
    """
    both = information[:, :, None] + information[:, None]
    cosine = rays @ rays.swapaxes(1, 2)
    share = weight / both
    q = share / np.maximum(1 - cosine * cosine, PARALLEL)
    qc = q * cosine
    ratio = information[:, None] / information[:, :, None]
    squares = rays[..., :, None] * rays[..., None, :]
    own = share.sum(axis=2)
    other = (q * ratio) @ squares.reshape(*rays.shape[:2], 9)
    cross = rays[..., :, None] * (qc @ rays)[..., None, :]
    back = ((qc * ratio) @ rays)[..., :, None] * rays[..., None, :]
    kept = (own + (qc * cosine).sum(axis=2))[..., None, None] * squares
    return np.asarray(own[..., None, None] * IDENTITY + other.reshape(squares.shape) + cross - back - kept)


def rivals_covariance(xyz: Array, center: Array, weights: Array, held: Array, exponent: float) -> Array:
    """What the possibility adds that candidates outside the modes show the balls: (M, 3, 3) m^2.

    It is their spread about the mode times its probability o^k / (h^k + o^k), with the weights h in the mode
    and o outside it, as in a mixture (Bar-Shalom, Li & Kirubarajan 2001, section 1.4.16).
    xyz: (N, 3) m; center: (M, 3) m; weights, held: (M, N); exponent: k.
    """
    outside = weights - held
    total = outside.sum(axis=1)
    ratio = total / np.maximum(held.sum(axis=1), TINY)
    odds = np.minimum(ratio, 1e6) ** exponent
    if odds.max(initial=0.0) < UNLIKELY:
        return np.zeros((len(center), 3, 3))
    offset = xyz - center[:, None]
    spread = (outside[..., None] * offset).swapaxes(1, 2) @ offset
    return np.asarray(spread * (odds / (1 + odds) / np.maximum(total, TINY))[:, None, None])

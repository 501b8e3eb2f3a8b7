"""Planes through points: total least squares, without the points that lie elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.triangulation import Triangulated, triangulate

FEWEST = 6
"""Points that a plane must rest on."""
TRIALS = 500
"""Random triples of points that are tried as planes."""
NEAR = 3.0
"""Points within so many sigma of a plane lie on it."""
MOST = 0.6
"""Share of the points that should lie on the plane; the one that is found has half of any points on it."""
NARROW = 0.1
"""Width over length of the points' extent under which they count as lying on a line."""
UNEVEN = 0.02
"""RMS distance of the points, m, above which a plane is not flat, or the calibration is off."""


@dataclass(frozen=True, eq=False)
class FittedPlane:
    """A plane and the points that it rests on.

    plane: (4,) [a b c d], unit normal towards the cameras, m; found: its triangulated points;
    distance: (N,) m, signed, of each point, NaN if it is not known; kept: (N,) bool, lies on the plane;
    width: of the points' extent over its length.
    """

    name: str
    plane: Array
    found: Triangulated
    distance: Array
    kept: Array
    width: float

    @property
    def rms_mm(self) -> float:
        """RMS distance of the points that lie on it."""
        return float(1000 * np.sqrt(np.square(self.distance[self.kept]).mean()))

    @property
    def max_mm(self) -> float:
        """Largest distance among them."""
        return float(1000 * np.abs(self.distance[self.kept]).max())

    @property
    def warnings(self) -> list[str]:
        """Warnings about the plane, each with its remedy."""
        found = []
        known = int(np.isfinite(self.distance).sum())
        if self.width < NARROW:
            found.append(f"the points of {self.name} lie nearly on a line; spread them over the plane")
        if self.kept.sum() < MOST * known:
            found.append(
                f"only {self.kept.sum()} of {known} points of {self.name} lie on one plane; "
                "do they belong to several?"
            )
        if self.rms_mm > 1000 * UNEVEN:
            found.append(
                f"the points of {self.name} are {self.rms_mm:.0f} mm from a plane (RMS); "
                "check the calibration: followspot calibrate check"
            )
        return found


def fit_plane(name: str, cameras: Sequence[Camera], marks: Sightings) -> FittedPlane:
    """The plane through points that at least two cameras saw. Raises FollowspotError for too few of them."""
    found = triangulate(cameras, marks.pixel)
    known = np.flatnonzero(np.isfinite(found.points[:, 0]))
    if len(known) < FEWEST:
        raise FollowspotError(
            f"plane {name}: {len(known)} of {len(marks.pixel)} points are seen alike by two cameras, "
            f"{FEWEST} needed; show more points where the views overlap"
        )
    points = found.points[known]
    plane, on = robust_plane(points)
    kept = np.zeros(len(found.points), bool)
    kept[known[on]] = True
    extent = np.linalg.svd(points[on] - points[on].mean(axis=0), compute_uv=False)
    centers = np.array([camera.center for camera in cameras])
    plane = facing(plane, centers[found.used[kept].any(axis=0)])
    distance = found.points @ plane[:3] + plane[3]
    return FittedPlane(name, plane, found, distance, kept, float(extent[1] / max(extent[0], 1e-12)))


def robust_plane(points: Array) -> tuple[Array, Array]:
    """The plane through most points, and which are on it: (N, 3) m -> (4,), (N,) bool.

    Of the planes through random triples the one with the least median distance (Rousseeuw 1984) tells
    the noise and the points that lie within `NEAR` sigma; total least squares through these ends it.
    """
    random = np.random.default_rng(0)
    triples = np.array([random.choice(len(points), 3, replace=False) for _ in range(TRIALS)])
    a, b, c = points[triples].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    proper = length > 1e-9 * length.max()
    normal, a = normal[proper] / length[proper, None], a[proper]
    distance = np.abs(points @ normal.T - np.einsum("ij,ij->i", a, normal))
    median = np.median(distance, axis=0)
    best = int(median.argmin())
    sigma = 1.4826 * (1 + 5 / max(len(points) - 3, 1)) * float(median[best])
    on = distance[:, best] <= max(NEAR * sigma, 1e-9)
    for _ in range(5):
        plane = total_least_squares(points[on])
        away = np.abs(points @ plane[:3] + plane[3])
        sigma = float(np.sqrt(np.square(away[on]).sum() / max(on.sum() - 3, 1)))
        on = away <= max(NEAR * sigma, 1e-9)
    return total_least_squares(points[on]), on


def total_least_squares(points: Array) -> Array:
    """[a b c d] with the least sum of squared distances: (N, 3) m -> (4,), unit normal."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle)[2][2]
    return np.append(normal, -normal @ middle)


def facing(plane: Array, centers: Array) -> Array:
    """The plane with its normal towards the most of these points, (C, 3) m."""
    sides = np.sign(centers @ plane[:3] + plane[3])
    return plane if sides.sum() >= 0 else -plane

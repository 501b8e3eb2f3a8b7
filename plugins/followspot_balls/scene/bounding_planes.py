"""Planes of a room, and those that bound the space of the targets: a ball may touch the floor, not sink in.

A position below is corrected as by a measurement of zero clearance, which is a state estimate with an
inequality constraint (Simon 2010, section 2.4): errors along the normal share their cause with those across
it, so the covariance says how far both go back. A position above keeps its place, for it may be right.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Positions

PARALLEL = 0.94
"""Cosine of the angle of normals from which one plane lies behind another, like the floor behind a table."""


def facing_planes(room: Room, centers: Array) -> Array:
    """Planes that bound the space of the targets, with the normal into it: (K, 4).

    All cameras see them from the same side, and none lies behind: targets are below a table, not below the
    floor. centers: (C, 3) m, of the cameras.
    """
    planes = np.array(list(room.planes.values())).reshape(-1, 4)
    side = np.sign(centers @ planes[:, :3].T + planes[:, 3])
    planes = (planes * side[0][:, None])[(side == side[:1]).all(axis=0)]
    away = centers.mean(axis=0) @ planes[:, :3].T + planes[:, 3]
    behind = (planes[:, :3] @ planes[:, :3].T > PARALLEL) & (away[:, None] < away)
    return np.asarray(planes[~behind.any(axis=1)])


def nearest_planes(planes: Array, xyz: Array, radius: Array) -> tuple[Array, Array]:
    """The planes nearest to the centres of balls: normals towards these (M, 3), and clearances (M,) m.

    planes: (K, 4), with normals to either side; xyz: (M, 3) m; radius: (M,) m. A ball that sinks into its
    plane has a negative clearance; without planes the clearances are infinite.
    """
    if not len(planes):
        return np.zeros(xyz.shape), np.full(len(xyz), np.inf)
    distance = xyz @ planes[:, :3].T + planes[:, 3]
    nearest = np.abs(distance).argmin(axis=1)
    above = distance[np.arange(len(xyz)), nearest]
    return planes[nearest, :3] * np.sign(above)[:, None], np.abs(above) - radius


def raised(positions: Positions, planes: Array, radii: Array, sigma: float) -> Positions:
    """The positions, of which those that sink into a plane are corrected by the one they sink into most.

    planes: (K, 4) with normals into the space; radii: (T,) m; sigma: of the planes' places, m. Positions
    without covariance stay.
    """
    clearance = positions.xyz @ planes[:, :3].T + planes[:, 3] - radii.take(positions.target)[:, None]
    depth = clearance.min(axis=1, initial=0.0)
    low = depth < 0
    if np.count_nonzero(low):
        low &= np.isfinite(positions.covariance).all(axis=(1, 2))
    if not np.count_nonzero(low):
        return positions
    normal = planes.take(clearance.argmin(axis=1), axis=0)[:, :3]
    across = (positions.covariance @ normal[..., None])[..., 0]
    gain = across / (np.vecdot(normal, across) + sigma * sigma)[:, None]
    gain = np.where(low[:, None], gain, 0.0)
    return replace(
        positions,
        xyz=positions.xyz - gain * depth[:, None],
        covariance=positions.covariance - gain[..., None] * across[:, None],
    )

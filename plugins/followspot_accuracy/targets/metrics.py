"""Figures of merit of one trajectory against the truth; each is a formula over F frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera
from followspot_accuracy.statistics import statistic

PAPER_UNIT = 4.572
"""15 ft, the unit of length of Jin & Qian 2008, m."""
PAPER_FRAMES = 100
"""Length of the subsequences in table 3 of the paper, frame intervals."""
ELLIPSOID_95 = 7.814728
"""Limit of chi-square with three degrees of freedom that 95 % are below."""


def transfers(elsewhere: Array, there: Array) -> int:
    """How often the track of a target transfers to another object; its way back does not count.

    elsewhere: (F,) whether the position is that of another object; there: (F,) whether there is a position.
    """
    known = elsewhere[there]
    return int(known[:1].sum() + (known[1:] & ~known[:-1]).sum())


def recoveries(trackable: Array, hidden: Array, pair: Array, right: Array) -> tuple[int, ...]:
    """Frames from each return of a target to the first right position.

    A target returns when it is visible in a colour and an infrared camera (`pair`) after it was not
    trackable. It counts until it is hidden again or the recording ends if no right position comes.
    All arguments are (F,) bool.
    """
    delays: list[int] = []
    returned, away = -1, False
    for frame, (visible, gone, both, ok) in enumerate(
        zip(trackable.tolist(), hidden.tolist(), pair.tolist(), right.tolist(), strict=True)
    ):
        away = away or not visible
        if away and visible and both and returned < 0:
            returned = frame
        if returned >= 0 and (ok or gone):
            delays.append(frame - returned)
            returned, away = -1, gone
    if returned >= 0:
        delays.append(len(right) - returned)
    return tuple(delays)


class Recoveries(NamedTuple):
    """Counts of frames in which a tracker sought a target (Jin & Qian 2008, section 4)."""

    sought: int
    """Frames in which it sought the target: the first one, and those after a frame without a position."""
    found: int
    """Frames of these with a position."""
    false: int
    """Frames of these whose position is not that of the target."""


def found_while_sought(there: Array, right: Array) -> Recoveries:
    """Recoveries of a target, and the false ones among them.

    there: (F,) whether there is a position; right: (F,) whether it is that of the target.
    """
    sought = ~np.concatenate([[False], there[:-1]]) if len(there) else np.zeros(0, bool)
    found = sought & there
    return Recoveries(int(sought.sum()), int(found.sum()), int((found & ~right).sum()))


def jerk_cost(xyz: Array) -> float:
    """Integral of the squared third derivative of the position (eq. 9-10 of Jin & Qian 2008).

    In the paper's units: lengths of 15 ft, time in frames, scaled to 100 frame intervals as in its
    table 3. xyz: (F, 3) m, NaN for no position; only runs of four count.
    """
    jerk = np.diff(xyz / PAPER_UNIT, n=3, axis=0)
    squared = np.square(jerk).sum(axis=1)
    known = squared[np.isfinite(squared)]
    return PAPER_FRAMES * statistic(known, np.mean)


def within_ellipsoid(errors: Array, sigma: Array) -> Array:
    """Which errors lie in the ellipsoid that 95 % of them should lie in: (N, 3) m each -> (N,) bool.

    The squared Mahalanobis distance is at most the limit of chi-square (Bar-Shalom, Li & Kirubarajan 2001,
    section 5.4). Tracks carry a standard deviation along each axis and no correlations, so right ones hold
    95 % of errors that are independent along the axes and 89 % of errors that all lie on one line.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = np.square(errors / sigma).sum(axis=1)
    return np.asarray(squared <= ELLIPSOID_95)


def reprojection(xyz: Array, truth: Array, cameras: Sequence[Camera]) -> Array:
    """Distances between the projections of positions and of the truth, px, over all cameras.

    xyz, truth: (N, 3) m. A camera counts if both have an image and the true one lies in its picture.
    """
    distances = [np.zeros(0)]
    for camera in cameras:
        seen = in_view(camera, truth)
        apart = np.linalg.norm(project(camera, xyz[seen]) - project(camera, truth[seen]), axis=1)
        distances.append(apart[np.isfinite(apart)])
    return np.concatenate(distances)


def in_view(camera: Camera, xyz: Array) -> Array:
    """(N,) whether points (N, 3) m project into the camera's picture; behind it they have no image."""
    pixel = project(camera, xyz)
    return np.asarray(((pixel >= 0) & (pixel <= np.array(camera.size) - 1)).all(axis=1))

"""A camera that was moved while the wand was waved: two poses explain its sightings, one pose does not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.geometry import Views, project
from followspot.messages import Array
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.triangulation import rays_of, solved
from followspot_calibrate.wand.hazards.support import support
from followspot_calibrate.wand.rounds import SIGMAS, RobustAdjustment

FEWEST = 30
"""Points before and after the move."""
BETTER = 0.7
"""Cost of two poses over that of one, below which the camera was moved."""
ROUNDS = 3
"""Rounds of fitting both poses and moving the moment of the change."""


@dataclass(frozen=True, eq=False)
class Moved:
    """number: of the camera; frame: the first after the move.

    kept_before: whether the pose that was found is the one before; left: cost of both poses over that of it.
    """

    number: int
    frame: int
    before: Camera
    after: Camera
    kept_before: bool
    left: float

    @property
    def turn(self) -> float:
        """Angle between the poses, rad."""
        cosine = (np.trace(self.before.rotation @ self.after.rotation.T) - 1) / 2
        return float(np.arccos(np.clip(cosine, -1, 1)))

    @property
    def shift(self) -> float:
        """Distance between the poses, in the unit of the frame of reference."""
        return float(np.linalg.norm(self.before.center - self.after.center))


def moved_cameras(adjusted: RobustAdjustment, sightings: Sightings) -> list[Moved]:
    """The cameras that were moved, the clearest first; at least three cameras are needed.

    A moved camera draws the points, and with them the others: so it is left out before the next is sought.
    """
    rays, trusted, found = rays_of(adjusted.cameras, sightings.pixel), adjusted.used.copy(), list[Moved]()
    waiting = set(range(len(adjusted.cameras)))
    while waiting:
        moves = (_moved(number, adjusted, sightings, rays, trusted) for number in sorted(waiting))
        clear = [one for one in moves if one is not None]
        if not clear:
            break
        found.append(min(clear, key=lambda one: one.left))
        waiting.remove(found[-1].number)
        trusted[:, found[-1].number] = False
    return found


def _moved(
    number: int, adjusted: RobustAdjustment, sightings: Sightings, rays: Array, trusted: Array
) -> Moved | None:
    """The move of one camera among the points that the others see. rays: (N, C, 3); trusted: (N, C) bool."""
    others = trusted.copy()
    others[:, number] = False
    points = solved(Views(adjusted.cameras), rays, others, adjusted.points)
    pixel = sightings.pixel[:, number]
    rows = np.flatnonzero(np.isfinite(points[:, 0] + pixel[:, 0]))
    rows = rows[np.argsort(sightings.frame[rows], kind="stable")]
    camera, limit = adjusted.cameras[number], SIGMAS * adjusted.sigma
    one, found = _cost(camera, points[rows], pixel[rows], limit), list[Moved]()
    for start in _starts(adjusted.used[rows, number]):
        for cut, before, after, cost in _rounds(camera, points[rows], pixel[rows], limit, start):
            fits = np.minimum(one, cost) < 1
            left = float(cost[fits].sum() / max(one[fits].sum(), 1e-9))
            kept = bool(one[:cut].mean() < one[cut:].mean())
            found.append(Moved(number, int(sightings.frame[rows[cut]]), before, after, kept, left))
    best = min(found, key=lambda move: move.left, default=None)
    return best if best is not None and best.left < BETTER else None


def _starts(used: Array) -> Sequence[int]:
    """Candidates for the moment: the middle, and the one that best separates sightings that fit."""
    count = len(used)
    cuts = np.arange(FEWEST, count - FEWEST)
    if not len(cuts):
        return ()
    fitting = np.cumsum(used)[cuts - 1]
    apart = np.abs(fitting / cuts - (used.sum() - fitting) / (count - cuts))
    return int(cuts[apart.argmax()]), count // 2


def _rounds(
    camera: Camera, points: Array, pixel: Array, limit: float, cut: int
) -> Iterator[tuple[int, Camera, Camera, Array]]:
    """Moment, pose before, pose after and the cost of each sighting, better from round to round."""
    for _ in range(ROUNDS):
        before = support(camera, points[:cut], pixel[:cut]).camera
        after = support(camera, points[cut:], pixel[cut:]).camera
        if before is None or after is None:
            return
        first, second = _cost(before, points, pixel, limit), _cost(after, points, pixel, limit)
        total = np.cumsum(first) + second.sum() - np.cumsum(second)
        cut = FEWEST + int(total[FEWEST - 1 : len(total) - FEWEST].argmin())
        yield cut, before, after, np.concatenate([first[:cut], second[cut:]])


def _cost(camera: Camera, points: Array, pixel: Array, limit: float) -> Array:
    """Squared errors over the limit, at most 1: (M,)."""
    away = np.nan_to_num(np.linalg.norm(project(camera, points) - pixel, axis=1), nan=np.inf)
    return np.asarray(np.minimum(np.square(away / limit), 1.0))

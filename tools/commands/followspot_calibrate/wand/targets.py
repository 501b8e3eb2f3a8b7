"""Targets shown alone, in the clips that templates are learnt from, as more points for the cameras.

A ball is seen by all cameras at once and more exactly than a bulb, but in few places: the wand begins, the
targets refine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot.errors import FollowspotError
from followspot_calibrate.adjust import Free, Middle, Progress, adjust
from followspot_calibrate.similarity import Similarity
from followspot_calibrate.target_sightings import TargetSightings
from followspot_calibrate.triangulation import error, triangulate
from followspot_calibrate.wand.alignment import Alignment
from followspot_calibrate.wand.rounds import SCALE, SIGMAS, RobustAdjustment, chosen
from followspot_calibrate.wand.solving import OFF_MIDDLE, REFINED, Solved

ROUNDS = 3
"""Rounds of adjusting and of selecting the sightings that fit."""
AGREEING = 0.5
"""Share of the targets' sightings that must agree about them."""


@dataclass(frozen=True, eq=False)
class Refined:
    """Cameras that suit the targets, too.

    points, sightings: how many of the targets' count; mean_px: mean reprojection error of these.
    """

    solved: Solved
    points: int
    sightings: int
    mean_px: float


def with_targets(
    solved: Solved,
    targets: TargetSightings,
    alignment: Alignment | None = None,
    progress: Progress | None = None,
) -> Refined:
    """The cameras adjusted to wand and targets together; lenses, too, if they are unknown.

    alignment: of these cameras with the room; then the result is in the room's frame, and known centres
    keep their accuracy. Raises FollowspotError if the cameras do not see the targets at the same places.
    """
    pixel, adjusted, anchors = solved.sightings.pixel, solved.adjusted, None
    free, middle = _unknown(solved)
    if alignment is not None:
        adjusted = _in_room(adjusted, alignment.transform)
        anchors = alignment.anchors and replace(alignment.anchors, sigma=SCALE * alignment.anchors.sigma)
    shown = _shown(adjusted, targets)
    _require_agreement(shown, targets)
    for number in range(ROUNDS):
        if progress is not None:
            progress("adjust to targets", number / ROUNDS)
        used = np.concatenate([adjusted.used, shown.used])
        better = adjust(
            adjusted.cameras,
            np.concatenate([adjusted.points, shown.points]),
            np.where(used[..., None], np.concatenate([pixel, targets.pixel]), np.nan),
            free,
            rods=solved.rods,
            middle=middle,
            anchors=anchors,
            scale=SCALE * np.concatenate([np.full(len(pixel), noise(adjusted)), targets.sigma]),
        )
        adjusted = chosen(better.cameras, pixel)
        shown = _shown(adjusted, targets)
    points, sightings = int(shown.used.any(axis=1).sum()), int(shown.used.sum())
    return Refined(replace(solved, adjusted=adjusted), points, sightings, float(np.nanmean(shown.distance)))


def _unknown(solved: Solved) -> tuple[Free, Middle | None]:
    """Free parameters: poses, and unknown lenses with principal points near the middle."""
    if solved.intrinsics != "free":
        return Free(), None
    sizes = solved.sightings.sizes
    return REFINED, Middle((sizes - 1) / 2, SCALE * OFF_MIDDLE * sizes.max(axis=1))


def _in_room(adjusted: RobustAdjustment, transform: Similarity) -> RobustAdjustment:
    """The cameras and points, moved to the room's frame."""
    cameras = tuple(transform.camera(camera) for camera in adjusted.cameras)
    return replace(adjusted, cameras=cameras, points=transform.points(adjusted.points))


def noise(adjusted: RobustAdjustment) -> float:
    """Standard deviation of a coordinate, px: larger than that of residuals, for each point fits its own."""
    sightings, points = adjusted.used.sum(), adjusted.used.any(axis=1).sum()
    return float(adjusted.sigma * np.sqrt(2 * sightings / (2 * sightings - 3 * points)))


def _shown(adjusted: RobustAdjustment, targets: TargetSightings) -> RobustAdjustment:
    """The targets as the cameras see them, and the sightings within `SIGMAS` of them."""
    found = triangulate(adjusted.cameras, targets.pixel)
    limit = SIGMAS * np.hypot(targets.sigma, adjusted.sigma)
    used = found.used & (error(found.residual) < limit[:, None])
    used &= used.sum(axis=1, keepdims=True) >= 2
    return RobustAdjustment(adjusted.cameras, found.points, used, found.residual, adjusted.sigma)


def _require_agreement(shown: RobustAdjustment, targets: TargetSightings) -> None:
    """Raises FollowspotError for clips that show something else in each camera."""
    seen = int(np.isfinite(targets.pixel[..., 0]).sum())
    if shown.used.sum() < AGREEING * seen:
        raise FollowspotError(
            f"only {shown.used.sum()} of {seen} sightings of the targets fit the cameras that the wand gave: "
            "clips must be synchronised and show one target each; leave --targets out if they are not"
        )

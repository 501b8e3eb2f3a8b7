"""Cameras that agree about tracked targets, as near to the given ones as that allows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Free, Prior, Progress, adjust
from followspot_calibrate.refine.planes import as_seen
from followspot_calibrate.similarity import Similarity, on_a_line, similarity
from followspot_calibrate.target_sightings import TargetSightings
from followspot_calibrate.wand.rounds import SCALE, RobustAdjustment, chosen

OPEN = Free(focal=True, aspect=True, center=True, distortion=2)
"""Free parameters."""
CAUSES = 3
"""Position, direction and lens share the error of a camera."""
ROUNDS = 4
"""Rounds of adjusting and of selecting the sightings that fit."""
FEWEST = 20
"""Sightings that fit which each camera needs."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """The refined cameras.

    pixel: (N, C, 2) px, the sightings; before, after: agreement of the given and the refined cameras;
    planes: for the refined cameras.
    """

    pixel: Array
    before: RobustAdjustment
    after: RobustAdjustment
    planes: Mapping[str, Array]


def refine(
    cameras: Sequence[Camera],
    sightings: TargetSightings,
    planes: Mapping[str, Array],
    progress: Progress | None = None,
) -> Refinement:
    """Cameras from sightings of targets.

    Each camera's prior sigma is about what the contradictions between the sightings suggest; the frame
    of reference and scale are those of the given centres. Raises FollowspotError for too few sightings.
    """
    pixel = sightings.pixel
    before = adjusted = chosen(cameras, pixel)
    require_sightings(before)
    prior = prior_of(before)
    for number in range(ROUNDS):
        if progress is not None:
            progress("adjust", number / ROUNDS)
        clean = np.where(adjusted.used[..., None], pixel, np.nan)
        better = adjust(
            adjusted.cameras, adjusted.points, clean, OPEN, prior=prior, scale=SCALE * sightings.sigma
        )
        adjusted = chosen(better.cameras, pixel)
    motion = onto(adjusted.cameras, cameras)
    after = chosen([motion.camera(camera) for camera in adjusted.cameras], pixel)
    return Refinement(pixel, before, after, as_seen(planes, cameras, after.cameras, after.points))


def require_sightings(adjusted: RobustAdjustment) -> None:
    """Raises FollowspotError that names every camera with too few sightings that fit."""
    counts = adjusted.used.sum(axis=0).tolist()
    few = [
        f"{camera.name}: {count} sightings of targets that fit the other cameras, {FEWEST} needed: "
        "carry targets through its view, or calibrate `wand` again"
        for camera, count in zip(adjusted.cameras, counts, strict=True)
        if count < FEWEST
    ]
    if few:
        raise FollowspotError("\n".join(few))


def prior_of(adjusted: RobustAdjustment) -> Prior:
    """Prior sigmas of cameras for a contradiction of so many px: each cause moves pixels alike."""
    pixels = SCALE * adjusted.sigma / np.sqrt(CAUSES)
    rows = []
    for camera in adjusted.cameras:
        focal, edge = camera.matrix[0, 0], max(camera.size) / 2 / camera.matrix[0, 0]
        depth = float(np.nanmedian(np.linalg.norm(adjusted.points - camera.center, axis=1)))
        lens = [*[1 / (focal * edge)] * 2, 1, 1, 1 / (focal * edge**3), 1 / (focal * edge**5)]
        rows.append([*[1 / focal] * 3, *[depth / focal] * 3, *lens])
    return Prior(adjusted.cameras, pixels * np.array(rows))


def onto(cameras: Sequence[Camera], given: Sequence[Camera]) -> Similarity:
    """The rigid motion that brings the centres nearest to the given ones; none if it is not determined."""
    source, target = (np.array([camera.center for camera in some]) for some in (cameras, given))
    if on_a_line(target):
        return Similarity(np.eye(3), np.zeros(3))
    return similarity(source, target, scaled=False)

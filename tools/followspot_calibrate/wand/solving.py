"""The whole way from sightings to cameras: pairs, a beginning, rounds of adjustment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from followspot import Camera
from followspot.geometry import undistort
from followspot_calibrate.adjust import Free, Middle, Progress, Rods
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.similarity import Similarity
from followspot_calibrate.wand.diagnosis import require_connected, require_placed, require_used, shallow
from followspot_calibrate.wand.growing import Beginning, grow
from followspot_calibrate.wand.guessing import guess
from followspot_calibrate.wand.pairs import Pair, match, trusted, working_rows
from followspot_calibrate.wand.rods import rods_of, scale_of
from followspot_calibrate.wand.rounds import Settled, chosen, settle

Intrinsics = Literal["known", "free", "auto"]
Outcome = Literal["known", "refined", "free"]
LIMIT = 0.01
"""Distance from an epipolar line of points that fit known intrinsics, over the longer side of the picture."""
BETTER = 0.9
"""Errors after refining known intrinsics over those before, below which the refined ones are kept."""
REFINED = Free(focal=True, center=True, distortion=2)
OFF_MIDDLE = 0.02
"""How far a principal point may be from the middle, one sigma over the longer side of the picture."""
ROUGH = Free(focal=True, distortion=1)
"""What two or three cameras already tell of intrinsics that are not good enough to place them all."""


@dataclass(frozen=True, eq=False)
class Solved:
    """Cameras from sightings, in a frame of their own.

    intrinsics: "known" as they were given, "refined" from those, or "free", found from nothing; rods: the
    wand, None where it has one bulb or no known length; then the unit of length is arbitrary.
    """

    sightings: Sightings
    pairs: Sequence[Pair]
    settled: Settled
    intrinsics: Outcome
    rods: Rods | None


def solve(
    sightings: Sightings,
    known: Sequence[Camera] | None,
    intrinsics: Intrinsics = "auto",
    length: float | None = None,
    progress: Progress | None = None,
) -> Solved:
    """Cameras from the sightings of a waved wand.

    known: cameras with intrinsics in the order of the sightings, if there are any; length: m, between the
    points labelled 0 and 1. With "auto" known intrinsics are kept unless others fit the data clearly better;
    the focal length is kept even then where the points lie too flat to determine it.
    Raises FollowspotError that names the cameras where the data do not tie them together.
    """
    rods = None if length is None else rods_of(sightings, length)
    own = None if intrinsics == "free" else known
    if own is None:
        begin = guess(sightings, progress)
    else:
        begin = _begin(sightings, own, [Free(), ROUGH] if intrinsics == "auto" else [Free()])
    require_connected(sightings, begin.pairs)
    require_placed(sightings, begin)
    cameras = [begin.placed[i] for i in range(len(sightings.cameras))]
    if rods is not None:
        cameras = _scaled(cameras, sightings, rods)
    if own is None:
        middle = _middle(sightings, None)
        outcome: Outcome = "free"
        settled = settle(cameras, sightings.pixel, REFINED, rods, middle, progress)
    else:
        settled, outcome = _with_known(sightings, own, cameras, intrinsics == "auto", rods, progress)
    require_used(sightings, settled)
    return Solved(sightings, begin.pairs, settled, outcome, rods)


def _with_known(
    sightings: Sightings,
    known: Sequence[Camera],
    placed: Sequence[Camera],
    may_refine: bool,
    rods: Rods | None,
    progress: Progress | None,
) -> tuple[Settled, Outcome]:
    """The placed cameras with known intrinsics, or with refined ones where those are clearly better."""
    cameras = [
        replace(camera, matrix=lens.matrix, distortion=lens.distortion)
        for camera, lens in zip(placed, known, strict=True)
    ]
    settled = settle(cameras, sightings.pixel, Free(), rods, progress=progress)
    if may_refine:
        free = replace(REFINED, focal=not shallow(settled))
        start = placed if free.focal else settled.cameras
        refined = settle(start, sightings.pixel, free, rods, _middle(sightings, known), progress)
        if refined.sigma < BETTER * settled.sigma:
            return refined, "refined"
    return settled, "known"


def _begin(sightings: Sightings, cameras: Sequence[Camera], attempts: Sequence[Free]) -> Beginning:
    """The cameras with their own intrinsics, placed by the first attempt that places all, or the best."""
    straight = np.stack([undistort(c, sightings.pixel[:, i]) for i, c in enumerate(cameras)], axis=1)
    pairs = match(straight, LIMIT * sightings.sizes.max(axis=1))
    fits = trusted(pairs, sightings.seen.shape)
    rows = working_rows(pairs, fits)
    pixel = np.where(fits[rows, :, None], sightings.pixel[rows], np.nan)
    placed: Mapping[int, Camera] = {}
    for free in attempts:
        grown = grow(cameras, pixel, pairs, free)
        if grown is not None and len(grown.placed) > len(placed):
            placed = grown.placed
        if len(placed) == len(cameras):
            break
    return Beginning(pairs, fits, placed)


def _middle(sightings: Sightings, known: Sequence[Camera] | None) -> Middle:
    """Where principal points are expected: where they are known to be, else in the middle of the pictures."""
    center = (sightings.sizes - 1) / 2 if known is None else np.array([c.matrix[:2, 2] for c in known])
    return Middle(center, OFF_MIDDLE * sightings.sizes.max(axis=1))


def _scaled(cameras: Sequence[Camera], sightings: Sightings, rods: Rods) -> list[Camera]:
    """The cameras in metres, so that the wand has its length."""
    scale = scale_of(chosen(cameras, sightings.pixel).points, rods)
    return [Similarity(np.eye(3), np.zeros(3), scale).camera(camera) for camera in cameras]

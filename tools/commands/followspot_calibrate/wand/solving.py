"""The whole way from sightings to cameras: pairs, a beginning, rounds of adjustment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from followspot import Camera
from followspot.geometry import undistort
from followspot.messages import Array
from followspot_calibrate.adjust import Free, Middle, Progress, Rods
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.similarity import Similarity
from followspot_calibrate.wand.diagnosis import (
    require_connected,
    require_depth,
    require_own_lenses,
    require_placed,
    require_spread,
    require_used,
    shallow,
)
from followspot_calibrate.wand.hazards.planar import in_a_plane
from followspot_calibrate.wand.incremental_sfm import InitialReconstruction, reconstruct
from followspot_calibrate.wand.initial_intrinsics import guess_intrinsics
from followspot_calibrate.wand.pairs import Pair, match, trusted, working_rows
from followspot_calibrate.wand.rods import rods_of, scale_of
from followspot_calibrate.wand.rounds import RobustAdjustment, adjust_robustly, chosen
from followspot_calibrate.wand.timing import Timed, in_step, synchronised, with_the_late

Intrinsics = Literal["known", "free", "auto"]
Outcome = Literal["known", "refined", "free"]
LIMIT = 0.01
"""Distance from an epipolar line of points that fit known intrinsics, over the longer side of the picture."""
BETTER = 0.9
"""Ratio of errors after and before refining known intrinsics below which the refined ones are kept."""
REFINED = Free(focal=True, center=True, distortion=2)
OFF_MIDDLE = 0.02
"""Distance of a principal point from the middle, one sigma over the longer side of the picture."""
ROUGH = Free(focal=True, distortion=1)
"""Accuracy to which two or three cameras determine intrinsics that cannot place all cameras."""


@dataclass(frozen=True, eq=False)
class Solved:
    """Cameras from sightings, in a frame of their own.

    intrinsics: "known" as they were given, "refined" from those, or "free", estimated; rods: the
    wand, None if it has one bulb or no known length; then the unit of length is arbitrary. timed: the
    sightings shifted into step, and by how much; planar: True if cameras with known
    lenses saw points in a plane.
    """

    timed: Timed
    pairs: Sequence[Pair]
    adjusted: RobustAdjustment
    intrinsics: Outcome
    rods: Rods | None
    planar: bool

    @property
    def sightings(self) -> Sightings:
        """Terms of the adjustment besides the sightings."""
        return self.timed.sightings


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
    the focal length is kept even then if the points lie too flat to determine it.
    Raises FollowspotError that names the cameras if the data do not connect them.
    """
    rods = None if length is None else rods_of(sightings, length)
    own = None if intrinsics == "free" else known
    require_spread(_straight(sightings, own), known=own is not None)
    timed, begin = _begun(sightings, own, intrinsics, progress)
    require_connected(timed.sightings, begin, own, rods)
    planar = own is not None and in_a_plane(_straight(timed.sightings, own), begin.pairs, sightings.sizes)
    require_placed(timed.sightings, begin, own, rods, planar=planar)
    cameras: Sequence[Camera] = [begin.placed[i] for i in range(len(sightings.cameras))]
    if rods is not None:
        cameras = _scaled(cameras, timed.sightings, rods)
    free = REFINED if own is None else Free()
    middle = _middle(sightings, own)
    if not planar:  # cameras without a significant lateness from motion
        timed, cameras = synchronised(
            cameras,
            sightings,
            timed,
            lambda now, pixel: adjust_robustly(now, pixel, free, rods, middle),
            free,
        )
    if own is None:
        outcome: Outcome = "free"
        adjusted = _with_unknown(timed.sightings, cameras, rods, middle, progress)
    else:
        adjusted, outcome = _with_known(timed.sightings, own, cameras, intrinsics == "auto", rods, progress)
        if planar:
            require_depth(timed.sightings, adjusted)
    require_used(timed.sightings, adjusted)
    return Solved(timed, begin.pairs, adjusted, outcome, rods, planar)


def _begun(
    sightings: Sightings, own: Sequence[Camera] | None, intrinsics: Intrinsics, progress: Progress | None
) -> tuple[Timed, InitialReconstruction]:
    """The sightings in step, and the first idea of a room that they give."""
    limit = LIMIT * sightings.sizes.max(axis=1)
    timed, pairs = in_step(sightings, lambda now: _straight(now, own), limit, progress)
    begin = _begin(timed.sightings, own, pairs, intrinsics, progress)
    shifted = with_the_late(sightings, timed, begin.placed, own)
    if shifted is None:
        return timed, begin
    pairs = match(_straight(shifted.sightings, own), limit)
    return shifted, _begin(shifted.sightings, own, pairs, intrinsics, progress)


def _with_unknown(
    sightings: Sightings,
    placed: Sequence[Camera],
    rods: Rods | None,
    middle: Middle | None,
    progress: Progress | None,
) -> RobustAdjustment:
    """The placed cameras with lenses that fit; their pixels are square unless others are clearly better."""
    square = adjust_robustly(placed, sightings.pixel, REFINED, rods, middle, progress)
    free = replace(REFINED, aspect=True)
    oblong = adjust_robustly(square.cameras, sightings.pixel, free, rods, middle, progress)
    return oblong if oblong.sigma < BETTER * square.sigma else square


def _with_known(
    sightings: Sightings,
    known: Sequence[Camera],
    placed: Sequence[Camera],
    may_refine: bool,
    rods: Rods | None,
    progress: Progress | None,
) -> tuple[RobustAdjustment, Outcome]:
    """The placed cameras with known intrinsics, or with refined ones if those are clearly better."""
    cameras = [
        replace(camera, matrix=lens.matrix, distortion=lens.distortion)
        for camera, lens in zip(placed, known, strict=True)
    ]
    adjusted = adjust_robustly(cameras, sightings.pixel, Free(), rods, progress=progress)
    require_own_lenses(sightings, adjusted)
    if may_refine:
        free = replace(REFINED, focal=not shallow(adjusted))
        start = placed if free.focal else adjusted.cameras
        refined = adjust_robustly(start, sightings.pixel, free, rods, _middle(sightings, known), progress)
        if refined.sigma < BETTER * adjusted.sigma:
            return refined, "refined"
    return adjusted, "known"


def _straight(sightings: Sightings, cameras: Sequence[Camera] | None) -> Array:
    """Pixels without the distortion of known lenses, or as they are: (N, C, 2) px."""
    if cameras is None:
        return sightings.pixel
    return np.stack([undistort(c, sightings.pixel[:, i]) for i, c in enumerate(cameras)], axis=1)


def _begin(
    sightings: Sightings,
    cameras: Sequence[Camera] | None,
    pairs: list[Pair],
    intrinsics: Intrinsics,
    progress: Progress | None,
) -> InitialReconstruction:
    """The cameras with their own intrinsics, placed by the first attempt that places all, or the best."""
    if cameras is None:
        return guess_intrinsics(sightings, progress)
    attempts = [Free(), ROUGH] if intrinsics == "auto" else [Free()]
    fits = trusted(pairs, sightings.seen.shape)
    rows = working_rows(pairs, fits)
    pixel = np.where(fits[rows, :, None], sightings.pixel[rows], np.nan)
    placed: Mapping[int, Camera] = {}
    for free in attempts:
        reconstruction = reconstruct(cameras, pixel, pairs, free)
        if reconstruction is not None and len(reconstruction.placed) > len(placed):
            placed = reconstruction.placed
        if len(placed) == len(cameras):
            break
    return InitialReconstruction(pairs, fits, placed)


def _middle(sightings: Sightings, known: Sequence[Camera] | None) -> Middle:
    """Expected principal points, (C, 2) px: the known ones, else the middle of the pictures."""
    center = (sightings.sizes - 1) / 2 if known is None else np.array([c.matrix[:2, 2] for c in known])
    return Middle(center, OFF_MIDDLE * sightings.sizes.max(axis=1))


def _scaled(cameras: Sequence[Camera], sightings: Sightings, rods: Rods) -> list[Camera]:
    """The cameras in metres, so that the wand has its length."""
    scale = scale_of(chosen(cameras, sightings.pixel).points, rods)
    return [Similarity(np.eye(3), np.zeros(3), scale).camera(camera) for camera in cameras]

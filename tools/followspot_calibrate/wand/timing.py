"""Tracks of cameras that are not synchronised, as if they were."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Progress
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.offset import Late, drift, lateness, nearest_shift, stretches
from followspot_calibrate.wand.hazards.steps import steps_late
from followspot_calibrate.wand.hazards.tracks import frame_step, resampled
from followspot_calibrate.wand.pairs import Pair, match
from followspot_calibrate.wand.rounds import Settled, chosen

LEAST = 0.2
"""Steps by which a camera must be late to be told; interpolated tracks are no better than that."""
SUSPECT = 0.25
"""Share of that from which on a lateness is looked at; at first, places are drawn by the late camera."""
SURE = 5.0
"""Sigmas of a lateness that is believed."""
LARGEST = 1.0
"""Clock offset that a room file may have, s."""
SMALL = 0.01
"""Steps; a change of lateness that small ends the search."""
ROUNDS = 10
LONGEST = 10.0
"""Times by which a step may be longer than the lateness that is left."""
BETTER = 0.9
"""Error of a camera after the correction over that before, from which on the correction is right."""

Settle = Callable[[Sequence[Camera], Array], Settled]
"""Adjusts cameras to pixels, (N, C, 2)."""


@dataclass(frozen=True, eq=False)
class Timed:
    """Sightings of one moment a row, and by how many frames each camera was late: (C,), 0 for most.

    drift: (C,) frames by which the lateness grew from the first half of the recording to the second, 0 where
    it did not.
    """

    sightings: Sightings
    late: Array
    drift: Array


def in_step(
    sightings: Sightings,
    straighten: Callable[[Sightings], Array],
    limit: Array,
    progress: Progress | None = None,
) -> tuple[Timed, list[Pair]]:
    """Whole frames are corrected before anything is placed; also the pairs, matched after the correction.

    straighten: pixels without lens distortion, (N, C, 2); limit: (C,) px.
    """
    straight = straighten(sightings)
    pairs = match(straight, limit)
    late = steps_late(sightings, straight, pairs, limit, progress)
    if late.any():
        sightings = replace(sightings, pixel=resampled(sightings, late))
        pairs = match(straighten(sightings), limit)
    return Timed(sightings, late, np.zeros_like(late)), pairs


def synchronised(cameras: Sequence[Camera], raw: Sightings, timed: Timed, settle: Settle) -> Timed:
    """Parts of a frame are corrected once the cameras have a place, in rounds with adjusting them.

    raw: as the file has them; timed: in step. Without a lateness that is sure nothing is changed.
    """
    least, some = LEAST * frame_step(raw), stretches(raw)
    before, pixel = chosen(cameras, timed.sightings.pixel[some]), timed.sightings.pixel[some]
    few = raw.rows(some)
    rest = lateness(before.cameras, before.points, pixel, few)
    if (
        not (np.abs(rest.frames) > np.maximum(SUSPECT * least, SURE * rest.sigma)).any()
        and not timed.late.any()
    ):
        return timed
    before = settle(cameras, pixel)
    start = _started(before, few, pixel)
    rest = lateness(before.cameras, before.points, pixel, few)
    if np.abs(start + rest.frames + timed.late).max() < least:
        return timed
    now, found = _refined(before, few, timed.late + start, settle)
    late = _from_most(found.frames, least)
    sure = np.abs(late) > np.maximum(least, SURE * found.sigma)
    grown = drift(now.cameras, now.points, few, np.where(sure, late, 0.0), SURE, 2 * least)
    better = _error(now) < BETTER * _error(before)
    if not timed.late.any() and not better[sure].any():
        return replace(timed, drift=grown)
    late = np.where(sure, late, 0.0)
    return Timed(replace(raw, pixel=resampled(raw, late)), late, grown)


def _refined(settled: Settled, sightings: Sightings, late: Array, settle: Settle) -> tuple[Settled, Late]:
    """Lateness from rounds of correcting and adjusting.

    A place that is free takes up the same part of it each time, so steps are as much longer (secant).
    """
    gain, before = np.ones(len(late)), np.zeros(len(late))
    for _ in range(ROUNDS):
        pixel = resampled(sightings, late)
        settled = settle(settled.cameras, pixel)
        rest = lateness(settled.cameras, settled.points, pixel, sightings)
        if np.abs(rest.frames).max() < SMALL * frame_step(sightings):
            break
        steady = (np.abs(rest.frames) > SURE * rest.sigma) & (rest.frames * before > 0)
        left = np.divide(rest.frames, before, out=np.zeros(len(late)), where=steady)
        gain = np.where(steady, np.clip(gain / np.maximum(1 - left, 1 / LONGEST), 1, LONGEST), 1.0)
        late, before = late + gain * rest.frames, rest.frames
    return settled, Late(late, rest.sigma)


def _started(settled: Settled, sightings: Sightings, pixel: Array) -> Array:
    """A lateness of each camera to begin with, (C,) frames; pixel: (N, C, 2) px, already nearly in step."""
    nearly = replace(sightings, pixel=pixel)
    late = [nearest_shift(c, settled.points, nearly, i) for i, c in enumerate(settled.cameras)]
    return np.array(late) if len(late) > 2 else np.zeros(len(late))


def _from_most(late: Array, least: float) -> Array:
    """Lateness relative to the largest number of cameras that are in step with each other: (C,) frames."""
    near = np.abs(late[:, None] - late) < least
    return np.asarray(late - np.median(late[near[near.sum(axis=1).argmax()]]))


def with_offsets(cameras: Sequence[Camera], timed: Timed, fps: float) -> list[Camera]:
    """The cameras with their clock offsets, s. Raises FollowspotError for one above `LARGEST`."""
    late = dict(zip(timed.sightings.cameras, (timed.late / fps).tolist(), strict=True))
    far = [f"{name} is {seconds:+.2f} s late" for name, seconds in late.items() if abs(seconds) > LARGEST]
    if far:
        raise FollowspotError(
            f"{', '.join(far)}, at most {LARGEST:g} s can be noted: "
            "cut the recordings so that they begin together, or leave --clock-offsets out"
        )
    return [replace(camera, clock_offset=round(late[camera.name], 6)) for camera in cameras]


def _error(settled: Settled) -> Array:
    """Median error of each camera over all its sightings, (C,) px."""
    return np.asarray(np.nanmedian(np.hypot(settled.residual[..., 0], settled.residual[..., 1]), axis=0))

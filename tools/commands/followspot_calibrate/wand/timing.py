"""Tracks of cameras that are not synchronised, as if they were."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Free, Progress
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.offset import Late, drift, lateness, nearest_shift, stretches
from followspot_calibrate.wand.hazards.steps import steps_late
from followspot_calibrate.wand.hazards.tracks import frame_step, resampled
from followspot_calibrate.wand.hazards.unplaced import agreeing_cameras, lenses_like
from followspot_calibrate.wand.pairs import Pair, match
from followspot_calibrate.wand.rounds import SIGMAS, NothingFits, RobustAdjustment, chosen

LEAST = 0.2
"""Smallest reported lateness, steps; interpolated tracks are no better than that."""
SURE = 5.0
"""Sigmas of a lateness that is believed."""
LARGEST = 1.0
"""Clock offset that a room file may have, s."""
SMALL = 0.01
"""Steps; a change of lateness that small ends the search."""
ROUNDS = 8
FARTHEST = 3.0
"""Frames that one round may add: motion is nearly straight for as long."""
BETTER = 0.9
"""Error of a camera after the correction over that before, from which on the correction is right."""

Adjust = Callable[[Sequence[Camera], Array], RobustAdjustment]
"""Adjusts cameras to pixels, (N, C, 2)."""


@dataclass(frozen=True, eq=False)
class Timed:
    """Sightings of one moment a row, and by how many frames each camera was late: (C,), 0 for most.

    drift: (C,) frames by which the lateness grew from the first half of the recording to the second, 0 if
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


def with_the_late(
    raw: Sightings, timed: Timed, placed: Mapping[int, Camera], known: Sequence[Camera] | None
) -> Timed | None:
    """The cameras that find a place once their tracks are shifted a little, in step; None without any.

    placed: the cameras that have a place, by number; known: lenses of all cameras, if there are any.
    """
    if not 2 <= len(placed) < len(raw.cameras):
        return None
    agree, late = agreeing_cameras(timed.sightings, placed), timed.late.copy()
    lenses = known or lenses_like(agree, raw)
    for number in (i for i in range(len(late)) if i not in placed):
        late[number] += nearest_shift(lenses[number], agree.points, timed.sightings, number)
    if (late == timed.late).all():
        return None
    return replace(timed, sightings=replace(raw, pixel=resampled(raw, late)), late=late)


def synchronised(
    cameras: Sequence[Camera], raw: Sightings, timed: Timed, adjust: Adjust, free: Free
) -> tuple[Timed, Sequence[Camera]]:
    """Parts of a frame are corrected once the cameras have a place, in rounds with adjusting them.

    Also the cameras as they are once that is corrected: adjusted to a late one they are too far off to begin.

    raw: as the file has them; timed: in step; free: what `adjust` adjusts. Without a certain
    lateness nothing is changed.
    """
    least, some = LEAST * frame_step(raw), stretches(raw)
    few, pixel = raw.rows(some), timed.sightings.pixel[some]
    begun = chosen(cameras, pixel)
    rest = lateness(begun, pixel, few, free)
    if not (np.abs(rest.frames) > np.maximum(least / 2, rest.sigma)).any() and not timed.late.any():
        return replace(timed, drift=drift(begun, few, timed.late, free, SURE, 2 * least)), cameras
    try:
        before = adjust(cameras, pixel)
        now, found = _refined(before, few, timed.late, adjust, free)
    except NothingFits:
        return timed, cameras
    late = _from_most(found.frames, least)
    sure = np.abs(late) > np.maximum(least, SURE * found.sigma)
    sure &= _error(now) < SIGMAS * now.sigma  # else something else is wrong with that camera
    growth = drift(now, few, np.where(sure, late, 0.0), free, SURE, 2 * least)
    better = _error(now) < BETTER * _error(before)
    if not timed.late.any() and not better[sure].any():
        return replace(timed, drift=growth), cameras
    late = np.where(sure, late, _kept(timed.late - np.median(found.frames - late), late, least))
    return Timed(replace(raw, pixel=resampled(raw, late)), late, growth), now.cameras


def _refined(
    adjusted: RobustAdjustment, sightings: Sightings, late: Array, adjust: Adjust, free: Free
) -> tuple[RobustAdjustment, Late]:
    """Lateness from rounds of correcting and adjusting."""
    cameras: Sequence[Camera] = adjusted.cameras
    for _ in range(ROUNDS):
        pixel = resampled(sightings, late)
        adjusted = adjust(cameras, pixel)
        rest = lateness(adjusted, pixel, sightings, free)
        late, cameras = late + np.clip(rest.frames, -FARTHEST, FARTHEST), rest.cameras
        if np.abs(rest.frames).max() < SMALL * frame_step(sightings):
            break
    return adjusted, replace(rest, frames=late)


def _kept(before: Array, late: Array, least: float) -> Array:
    """Lateness of cameras without a significant one from motion, (C,) frames: whole frames, or none.

    before: lateness in whole frames, relative to the same cameras as `late`.
    """
    doubtful = (np.abs(late) > least) & (np.abs(before) > least)
    return np.where(doubtful, before, 0.0)


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


def _error(adjusted: RobustAdjustment) -> Array:
    """Median error of each camera over all its sightings, (C,) px."""
    return np.asarray(np.nanmedian(np.hypot(adjusted.residual[..., 0], adjusted.residual[..., 1]), axis=0))

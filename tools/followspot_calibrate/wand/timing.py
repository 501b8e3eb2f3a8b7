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
from followspot_calibrate.wand.hazards.offset import Late, drift, lateness
from followspot_calibrate.wand.hazards.steps import steps_late
from followspot_calibrate.wand.hazards.tracks import frame_step, resampled
from followspot_calibrate.wand.pairs import Pair, match
from followspot_calibrate.wand.rounds import Settled, chosen

LEAST = 0.2
"""Steps by which a camera must be late to be told; interpolated tracks are no better than that."""
SURE = 5.0
"""Sigmas of a lateness that is believed."""
LARGEST = 1.0
"""Clock offset that a room file may have, s."""
SMALL = 0.01
"""Steps; a change of lateness that small ends the search."""
ROUNDS = 6
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
    least, pixel = LEAST * frame_step(raw), timed.sightings.pixel
    rest = lateness(cameras, chosen(cameras, pixel).points, pixel, raw)
    if not _sure(rest.frames, rest, least).any() and not timed.late.any():
        return timed
    before = now = settle(cameras, pixel)
    late = timed.late
    for _ in range(ROUNDS):
        rest = lateness(now.cameras, now.points, pixel, raw)
        late = late + rest.frames
        pixel = resampled(raw, late)
        now = settle(now.cameras, pixel)
        if np.abs(rest.frames).max() < SMALL * frame_step(raw):
            break
    told = _sure(late, rest, least) & (_error(now) < BETTER * _error(before))
    late = np.where(told, late - np.median(late), timed.late)
    corrected = replace(raw, pixel=resampled(raw, late))
    return Timed(corrected, late, drift(now.cameras, now.points, corrected, SURE, least))


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


def _sure(late: Array, rest: Late, least: float) -> Array:
    """Which cameras are late beyond doubt: (C,) bool."""
    return np.asarray(np.abs(late) > np.maximum(least, SURE * rest.sigma))


def _error(settled: Settled) -> Array:
    """Median error of each camera over all its sightings, (C,) px."""
    return np.asarray(np.nanmedian(np.hypot(settled.residual[..., 0], settled.residual[..., 1]), axis=0))

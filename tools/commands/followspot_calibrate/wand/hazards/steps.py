"""Cameras that are whole frames out of step: found from pairs alone, before any camera has a place.

A pair in step agrees on one epipolar geometry. One that is not agrees on it best once one of the tracks is
shifted by as many frames.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.messages import Array
from followspot_calibrate.adjust import Progress
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.tracks import frame_step, resampled
from followspot_calibrate.wand.pairs import FEWEST, Pair, agreeing

REACH = 100
"""Steps that a camera may be early or late."""
STRIDE = 2
"""Steps between the shifts that are tried first; a step beside the right one most points still agree."""
TRIALS = 500
"""Trials of the search for an epipolar geometry at one shift."""
IN_STEP = 0.85
"""Share of agreeing points over that of the best pair from which on a pair is in step."""
AGREE = 0.45
"""Share of points that agree in a pair in step; with 30 % of reflections in both views half do.

At another shift it is their share of what both see as it is, for the few that overlap agree easily."""
ALONE = 0.9
"""The same for a single pair, which has no best one to start from."""
BETTER = 1.4
"""Agreement at the right shift over that without one."""
PARTNERS = 2
"""Cameras in step that a further one is compared with before it is given up, least agreeing first."""


def steps_late(
    sightings: Sightings, straight: Array, pairs: Sequence[Pair], limit: Array, progress: Progress | None
) -> Array:
    """Lateness of each camera in whole frames, relative to most of them: (C,), 0 if none is found.

    straight: (N, C, 2) px without distortion; pairs: that agree without a shift; limit: (C,) px.
    """
    share = shares(pairs, len(sightings.cameras))
    late = np.zeros(len(sightings.cameras))
    joined = _in_step(share)
    seen = np.isfinite(straight[..., 0]).sum(axis=0)
    waiting = sorted(set(range(len(late))) - joined, key=lambda camera: -seen[camera])
    tracks = Sightings(sightings.cameras, sightings.sizes, sightings.frame, sightings.label, straight)
    for number, camera in enumerate(waiting):
        if progress is not None:
            progress(f"is {sightings.cameras[camera]} in step", number / len(waiting))
        found = _shift(tracks, camera, sorted(joined), late, share, limit)
        if found is not None:
            late[camera] = found
            joined.add(camera)
    values, counts = np.unique(late, return_counts=True)
    return np.asarray(late - values[counts.argmax()])


def shares(pairs: Sequence[Pair], cameras: int) -> Array:
    """Share of the points of each pair that agree, (C, C); NaN if too few are shared."""
    share = np.full((cameras, cameras), np.nan)
    for pair in pairs:
        if len(pair.rows) >= FEWEST:
            share[pair.first, pair.second] = share[pair.second, pair.first] = pair.agree.mean()
    return share


def _in_step(share: Array) -> set[int]:
    """The largest set of cameras that are in step with each other as they are; at least one."""
    best = np.nan_to_num(share).max(initial=0.0)
    alone = np.isfinite(share).sum() <= 2
    near = share >= (ALONE if alone else max(IN_STEP * best, AGREE))
    sets = [_reached(near, camera) for camera in range(len(share))]
    return max(sets, key=len)


def _reached(near: Array, start: int) -> set[int]:
    reached, fresh = {start}, [start]
    while fresh:
        others = set(np.flatnonzero(near[fresh.pop()]).tolist()) - reached
        reached |= others
        fresh += sorted(others)
    return reached


def _shift(
    tracks: Sightings, camera: int, joined: Sequence[int], late: Array, share: Array, limit: Array
) -> float | None:
    """The shift at which a camera agrees with those in step; None if there is none."""
    common = {other: int((tracks.seen[:, other] & tracks.seen[:, camera]).sum()) for other in joined}
    enough = max(FEWEST, max(common.values()) / 2)
    partners = [other for other in joined if common[other] >= enough]
    for other in sorted(partners, key=lambda one: float(share[camera, one]))[:PARTNERS]:
        trial = np.zeros(len(late))
        trial[other] = late[other]
        fixed = resampled(tracks, trial)[:, other]
        largest, step = float(max(limit[camera], limit[other])), frame_step(tracks)
        best, agree = float(late[other]), 0.0
        for steps in (np.arange(-REACH, REACH + 1, STRIDE), np.arange(1 - STRIDE, STRIDE)):
            shifts = best + step * steps
            found = [_agreeing(tracks, camera, shift, fixed, largest) for shift in shifts.tolist()]
            best, agree = float(shifts[np.argmax(found)]), max(found) / common[other]
        if agree >= max(AGREE, BETTER * np.nan_to_num(share[camera, other])):
            return best
    return None


def _agreeing(tracks: Sightings, camera: int, shift: float, fixed: Array, limit: float) -> int:
    """Number of points of a shifted track that fit one epipolar geometry with a fixed track. limit: px."""
    trial = np.zeros(len(tracks.cameras))
    trial[camera] = shift
    moved = resampled(tracks, trial)[:, camera]
    both = np.isfinite(moved[:, 0]) & np.isfinite(fixed[:, 0])
    return int(agreeing(fixed[both], moved[both], limit, TRIALS).sum())

"""Faults in the data of a calibration: which cameras, why, and what to do."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Rods
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.linear import on_a_line
from followspot_calibrate.wand.hazards.planar import REMEDY
from followspot_calibrate.wand.hazards.swapped import exchanged_lenses
from followspot_calibrate.wand.hazards.unlinked import other_size, why_unlinked
from followspot_calibrate.wand.hazards.unplaced import agreeing_cameras, exchanged, reasons
from followspot_calibrate.wand.incremental_sfm import InitialReconstruction
from followspot_calibrate.wand.pairs import FEWEST, Pair
from followspot_calibrate.wand.resection import FEWEST as TIED
from followspot_calibrate.wand.rounds import RobustAdjustment

IN_A_PLANE = f"the points lie in one plane, which does not determine the poses of all cameras: {REMEDY}"
ON_A_LINE = f"the points lie along one line, which determines no poses: {REMEDY}"
LEAST = 12
"""Points that a camera must keep."""
LEAST_SHARE = 0.4
"""Share of its points below which a pose that fits the others is chance."""
DEEP = 2.0
"""Ratio of the farthest to the nearest points below which they leave the focal length open."""
MOST_OF = 0.7
"""Share of a camera's points that fit, over that of the best camera, below which its place is in doubt."""


def require_spread(straight: Array, *, known: bool) -> None:
    """Raises FollowspotError if the wand was waved along a line.

    straight: (N, C, 2) px, without the distortion of lenses that are known.
    """
    if on_a_line(straight, 1 if known else 2):
        raise FollowspotError(ON_A_LINE)


def require_connected(
    sightings: Sightings, begin: InitialReconstruction, known: Sequence[Camera] | None, rods: Rods | None
) -> None:
    """Raises FollowspotError if the cameras fall into groups that share too few points.

    The error explains why a camera agrees with no other, or else names the groups and where to wave.
    """
    names = sightings.cameras
    group = _groups(begin.pairs, len(names))
    if len(set(group)) == 1:
        return
    if begin.placed:
        explained = reasons(agreeing_cameras(sightings, begin.placed), sightings, known, rods)
        if explained:
            raise FollowspotError("\n".join(dict.fromkeys(explained.values())))
    apart = min(set(group), key=group.count)
    groups = [", ".join(names[i] for i, g in enumerate(group) if g == one) for one in dict.fromkeys(group)]
    lines = [
        f"the cameras fall into {len(groups)} groups without enough points in common: {'; '.join(groups)}"
    ]
    across = [pair for pair in begin.pairs if group[pair.first] != group[pair.second]]
    for camera in (i for i, g in enumerate(group) if g == apart):
        own = (pair for pair in across if camera in (pair.first, pair.second))
        best = max(own, key=lambda pair: (pair.shared, len(pair.rows)))
        lines.append(why_unlinked(sightings, best.first, best.second) or _shares(names, best))
    raise FollowspotError("\n".join(lines))


def require_placed(
    sightings: Sightings,
    begin: InitialReconstruction,
    known: Sequence[Camera] | None,
    rods: Rods | None,
    *,
    planar: bool,
) -> None:
    """Raises FollowspotError that names the cameras that found no place among the others, and why.

    known: cameras with intrinsics, if there are any; planar: whether the points lie in a plane.
    """
    names = sightings.cameras
    absent = [i for i in range(len(names)) if i not in begin.placed]
    if not begin.placed:
        raise FollowspotError(
            "no two cameras see the points from places that are far enough apart; "
            "wave through the whole room, and see that the cameras are synchronised"
        )
    if absent and planar:
        raise FollowspotError(IN_A_PLANE)
    if absent:
        agree = agreeing_cameras(sightings, begin.placed)
        explained = reasons(agree, sightings, known, rods)
        if not begin.placed.keys() & explained.keys():
            explained = {i: explained.get(i) or _unplaced(sightings, begin, i) for i in absent}
        raise FollowspotError("\n".join(dict.fromkeys(explained.values())))


def require_own_lenses(sightings: Sightings, adjusted: RobustAdjustment) -> None:
    """Raises FollowspotError if two cameras see the points through the lens of the other."""
    pair = exchanged_lenses(adjusted, sightings.pixel)
    if pair is not None:
        raise FollowspotError(exchanged(sightings.cameras, pair))


def require_depth(sightings: Sightings, adjusted: RobustAdjustment) -> None:
    """Raises FollowspotError if points in a plane gave some cameras the wrong one of their two poses."""
    share = adjusted.used.sum(axis=0) / np.maximum(1, sightings.seen.sum(axis=0))
    if share.min() < MOST_OF * share.max():
        raise FollowspotError(IN_A_PLANE)


def require_used(sightings: Sightings, adjusted: RobustAdjustment) -> None:
    """Raises FollowspotError if few sightings of a camera fit in the end."""
    counts, seen = adjusted.used.sum(axis=0), sightings.seen.sum(axis=0)
    for number, name in enumerate(sightings.cameras):
        needed = max(LEAST, math.ceil(LEAST_SHARE * seen[number]))
        if counts[number] < needed:
            cause = (
                other_size(sightings, number) or "is it synchronised, and does the file say the right camera?"
            )
            raise FollowspotError(
                f"only {counts[number]} of {seen[number]} points of {name} fit what the other cameras see, "
                f"{needed} needed: {cause}"
            )


def shallow(adjusted: RobustAdjustment) -> dict[str, float]:
    """Cameras with points that do not determine a focal length, and the ratio of their depths."""
    ratios = {
        camera.name: far / near
        for number, camera in enumerate(adjusted.cameras)
        for near, far in (depths(adjusted, number),)
    }
    return {name: ratio for name, ratio in ratios.items() if ratio < DEEP}


def depths(adjusted: RobustAdjustment, number: int) -> tuple[float, float]:
    """Depth of the nearest and the farthest points that a camera sees, but for 2 % at each end."""
    camera, rows = adjusted.cameras[number], adjusted.used[:, number]
    if not rows.any():
        return 1.0, 1.0
    depth = adjusted.points[rows] @ camera.rotation[2] + camera.translation[2]
    near, far = np.percentile(depth, [2, 98])
    return float(near), float(far)


def _groups(pairs: Sequence[Pair], count: int) -> list[int]:
    """The group of each of so many cameras: its members are connected by pairs that share enough points."""
    group = list(range(count))
    for pair in pairs:
        if pair.shared >= FEWEST:
            group = [group[pair.first] if g == group[pair.second] else g for g in group]
    return group


def _shares(names: Sequence[str], pair: Pair) -> str:
    if len(pair.rows) >= FEWEST:
        return (
            f"{names[pair.first]}-{names[pair.second]} see the points at the same {len(pair.rows)} moments, "
            f"but only {pair.shared} of them fit together, {FEWEST} needed: are both of the same recording, "
            "in step within a few frames, not mirrored, and their lenses as the room has them?"
        )
    return (
        f"{names[pair.first]}-{names[pair.second]} share {len(pair.rows)} points, {FEWEST} needed: "
        "wave where both can see it"
    )


def _unplaced(sightings: Sightings, begin: InitialReconstruction, camera: int) -> str:
    """Points that this camera shares with two others are what places it."""
    name, placed = sightings.cameras[camera], sorted(begin.placed)
    views = begin.trusted[:, placed].sum(axis=1)
    common = int((begin.trusted[:, camera] & (views >= 2)).sum())
    others = ", ".join(sightings.cameras[i] for i in placed)
    if common < TIED:
        return (
            f"{name} shares {common} points with two of {others} at once, {TIED} needed: "
            "wave where three cameras can see it"
        )
    return (
        f"{name} shares {common} points with {others}, but sees them where no camera could: "
        "are its points of the same recording, its lens as the room has it, and was it not moved?"
    )

"""What is wrong with the data of a calibration: which cameras, why, and what to do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.errors import FollowspotError
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.growing import Beginning
from followspot_calibrate.wand.pairs import FEWEST, Pair
from followspot_calibrate.wand.placing import FEWEST as TIED
from followspot_calibrate.wand.rounds import Settled

LEAST = 12
"""Points that a camera must keep."""
DEEP = 2.0
"""Ratio of the farthest to the nearest points below which they leave the focal length open."""
MANY = 0.2
"""Share of a camera's sightings that fit nothing from which on something is wrong with it."""


def require_connected(sightings: Sightings, pairs: Sequence[Pair]) -> None:
    """Raises FollowspotError where the cameras fall into groups that share too few points."""
    names = sightings.cameras
    group = list(range(len(names)))
    for pair in pairs:
        if pair.shared >= FEWEST:
            group = [group[pair.first] if g == group[pair.second] else g for g in group]
    if len(set(group)) == 1:
        return
    apart = min(set(group), key=group.count)
    lines = []
    for camera in (i for i, g in enumerate(group) if g == apart):
        across = [p for p in pairs if camera in (p.first, p.second) and group[p.first] != group[p.second]]
        best = max(across, key=lambda pair: pair.shared)
        lines.append(_shares(names, best))
    raise FollowspotError("\n".join(lines))


def require_placed(sightings: Sightings, begin: Beginning) -> None:
    """Raises FollowspotError that names the cameras that found no place among the others."""
    names = sightings.cameras
    absent = [i for i in range(len(names)) if i not in begin.placed]
    if not begin.placed:
        raise FollowspotError(
            "no two cameras see the points from places that are far enough apart; "
            "wave through the whole room, and see that the cameras are synchronised"
        )
    if absent:
        raise FollowspotError("\n".join(_unplaced(sightings, begin, camera) for camera in absent))


def require_used(sightings: Sightings, settled: Settled) -> None:
    """Raises FollowspotError where hardly a sighting of a camera fits in the end."""
    counts = settled.used.sum(axis=0)
    for name, count, seen in zip(sightings.cameras, counts, sightings.seen.sum(axis=0), strict=True):
        if count < LEAST:
            raise FollowspotError(
                f"only {count} of {seen} points of {name} fit what the other cameras see, {LEAST} needed: "
                "is it synchronised, and does the file say the right camera?"
            )


def warnings_of(sightings: Sightings, settled: Settled, *, focal: bool) -> list[str]:
    """What a user should know though the calibration came to an end; focal: whether it had to be found."""
    found = []
    for number, camera in enumerate(settled.cameras):
        total, used = int(sightings.seen[:, number].sum()), int(settled.used[:, number].sum())
        if used < FEWEST:
            found.append(f"{camera.name} rests on {used} points, {FEWEST} needed: wave in its view")
        elif used < (1 - MANY) * total:
            found.append(
                f"{100 * (1 - used / total):.0f} % of the points of {camera.name} fit no other camera: "
                "look for reflections, or for a camera that is not synchronised or was moved"
            )
    flat = shallow(settled) if focal else {}
    if flat:
        ratios = ", ".join(f"{name} {ratio:.1f}" for name, ratio in flat.items())
        found.append(
            f"the depth of the points, farthest over nearest, is under {DEEP:g} ({ratios}): the focal length "
            "is not well determined; wave nearer to the camera and farther off, or calibrate its intrinsics"
        )
    return found


def shallow(settled: Settled) -> dict[str, float]:
    """Cameras whose points do not determine a focal length, and the ratio of their depths."""
    ratios = {
        camera.name: far / near
        for number, camera in enumerate(settled.cameras)
        for near, far in (depths(settled, number),)
    }
    return {name: ratio for name, ratio in ratios.items() if ratio < DEEP}


def depths(settled: Settled, number: int) -> tuple[float, float]:
    """Depth of the nearest and the farthest points that a camera sees, but for 2 % at each end."""
    camera, rows = settled.cameras[number], settled.used[:, number]
    if not rows.any():
        return 1.0, 1.0
    depth = settled.points[rows] @ camera.rotation[2] + camera.translation[2]
    near, far = np.percentile(depth, [2, 98])
    return float(near), float(far)


def _shares(names: Sequence[str], pair: Pair) -> str:
    return (
        f"{names[pair.first]}-{names[pair.second]} share {pair.shared} points, {FEWEST} needed: "
        "wave where both can see it"
    )


def _unplaced(sightings: Sightings, begin: Beginning, camera: int) -> str:
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
        "is its picture mirrored, is it swapped with another camera or not synchronised?"
    )

"""From an arbitrary frame to the room's: by known camera centres, a marker of known points, or neither."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Anchors
from followspot_calibrate.similarity import NEAR, Similarity, agreeing, on_a_line, similarity, spread
from followspot_calibrate.triangulation import triangulate
from followspot_calibrate.wand.hazards.swapped import exchanged_places

WRONG_SCALE = 0.02
"""Difference of a known wand from known places, over its length, that gives a warning."""

MIRROR = np.array([1.0, 1.0, -1.0])
FEWEST_REFLECTED = 4
"""Cameras that tell a room from its mirror image; three fit either."""

EXACT = 1e-5
"""Known centres are not taken to be more exact, m."""

Method = Literal["centers", "marker", "none"]


@dataclass(frozen=True, eq=False)
class Marker:
    """Points with known places, (M, 3) m, as cameras see them: pixel (M, C, 2) px, NaN if not seen."""

    places: Array
    pixel: Array


@dataclass(frozen=True, eq=False)
class Alignment:
    """The alignment of the frame of reference.

    rms: m, of the known places, None without any; metric: True if the unit is the metre; anchors: known
    centres of the cameras that agree, with the accuracy of their fit.
    """

    method: Method
    transform: Similarity
    rms: float | None
    metric: bool
    warnings: tuple[str, ...] = ()
    anchors: Anchors | None = None


def onto_centers(cameras: Sequence[Camera], known: Mapping[str, Array], *, scaled: bool) -> Alignment:
    """Aligns camera centres with their known places, m; leaves out cameras that were moved since.

    scaled: True if they give the scale too; else it stays. Raises FollowspotError for fewer than three
    centres or centres on a line, if two cameras have exchanged places, and if all stand in a mirror image.
    """
    named = [camera for camera in cameras if camera.name in known]
    source = np.array([camera.center for camera in named]).reshape(-1, 3)
    target = np.array([known[camera.name] for camera in named]).reshape(-1, 3)
    _require_room([camera.name for camera in named], source, target)
    agree = agreeing(source, target, scaled=True)
    found = _aligned("centers", source, target, agree, scaled)
    apart = np.linalg.norm(found.transform.points(source) - target, axis=1)
    moved = tuple(
        f"{camera.name} is {1000 * distance:.0f} mm from its known centre and was left out of the alignment: "
        "was it moved?"
        for camera, distance, fits in zip(named, apart, agree, strict=True)
        if not fits
    )
    fitting = {camera.name for camera, fits in zip(named, agree, strict=True) if fits}
    anchors = _anchors(cameras, {name: known[name] for name in fitting}, found.rms, 7 if scaled else 6)
    return replace(found, warnings=found.warnings + moved, anchors=anchors)


def onto_marker(cameras: Sequence[Camera], marker: Marker, *, scaled: bool) -> Alignment:
    """Points of a marker to their known places. Raises FollowspotError if fewer than three are found."""
    points = triangulate(cameras, marker.pixel).points
    found = np.isfinite(points).all(axis=1)
    if on_a_line(marker.places[found]):
        raise FollowspotError(
            f"{found.sum()} points of the marker are seen by two cameras: "
            "three are needed that are not on a line; let more cameras see them"
        )
    source, target = points[found], marker.places[found]
    return _aligned("marker", source, target, agreeing(source, target), scaled)


def onto_itself(cameras: Sequence[Camera], *, metric: bool) -> Alignment:
    """The middle of the camera centres becomes the origin; axes as they are."""
    middle = np.mean([camera.center for camera in cameras], axis=0)
    lacks = (
        ()
        if metric
        else ("the scale is unknown: lengths are not metres; give --length, --align or --marker",)
    )
    return Alignment("none", Similarity(np.eye(3), -middle), None, metric, lacks)


def _require_room(names: Sequence[str], source: Array, target: Array) -> None:
    """Raises FollowspotError if known centres give no frame of reference, two are exchanged or all mirrored.

    source, target: (N, 3) m, the cameras' centres as they were found and as they are known.
    """
    if on_a_line(target):
        raise FollowspotError(
            f"{len(names)} known camera centres do not give a frame of reference: "
            "three are needed that are not on a line; give them, a marker, or --align none"
        )
    swapped = exchanged_places(source, target)
    if swapped is not None:
        one, other = (names[number] for number in swapped)
        raise FollowspotError(
            f"{one} and {other} are exchanged: each is at the known place of the other; "
            "exchange their recordings, or their names in the room file, or give --align none"
        )
    reflected = _met(source * MIRROR, target)
    if reflected >= FEWEST_REFLECTED and reflected > _met(source, target):
        raise FollowspotError(
            "the cameras stand in a mirror image of their known places: the pictures of all are flipped; "
            "u is counted from the left and v from the top, or give --align none"
        )


def _met(source: Array, target: Array) -> int:
    """How many points are near their places after the similarity that most agree on."""
    agree = agreeing(source, target)
    met = similarity(source[agree], target[agree]).points(source)
    return int((np.linalg.norm(met - target, axis=1) < NEAR * spread(target)).sum())


def _anchors(
    cameras: Sequence[Camera], known: Mapping[str, Array], rms: float | None, degrees: int
) -> Anchors | None:
    """Known centres, m, with the sigma that their residuals suggest; None if these leave no freedom for that.

    rms: of the residuals, m; degrees: degrees of freedom of the transform that was fitted.
    """
    free = 3 * len(known) - degrees
    if rms is None or free <= 0:
        return None
    sigma = max(rms * np.sqrt(len(known) / free), EXACT)
    center = np.array([known.get(camera.name, np.zeros(3)) for camera in cameras])
    return Anchors(center, np.array([sigma if camera.name in known else np.inf for camera in cameras]))


def _aligned(method: Method, source: Array, target: Array, agree: Array, scaled: bool) -> Alignment:
    best = similarity(source[agree], target[agree])
    transform = best if scaled else similarity(source[agree], target[agree], scaled=False)
    error = np.linalg.norm(transform.points(source[agree]) - target[agree], axis=1)
    rms = float(np.sqrt(np.square(error).mean()))
    warnings = []
    if not scaled and abs(best.scale - 1) > WRONG_SCALE:
        warnings.append(
            f"the wand says that lengths are {1 / best.scale:.3f} times those between the known places: "
            "check --length"
        )
    if scaled and rms > WRONG_SCALE * spread(target):
        warnings.append(
            f"the known places are met within {1000 * rms:.0f} mm only: check them, and which camera is which"
        )
    return Alignment(method, transform, rms, True, tuple(warnings))

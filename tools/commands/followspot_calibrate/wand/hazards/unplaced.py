"""Why a camera finds no place among the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.adjust import Rods
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.bulbs import exchanged_bulbs, others_of
from followspot_calibrate.wand.hazards.mirrored import Mirrored, mirrored
from followspot_calibrate.wand.hazards.swapped import lens_of_another
from followspot_calibrate.wand.rounds import chosen


@dataclass(frozen=True, eq=False)
class Agreeing:
    """The cameras that agree, by number, and the points that they see, (N, 3)."""

    placed: Mapping[int, Camera]
    points: Array


def agreeing_cameras(sightings: Sightings, placed: Mapping[int, Camera]) -> Agreeing:
    """The points as known from the cameras with poses."""
    numbers = sorted(placed)
    return Agreeing(placed, chosen([placed[i] for i in numbers], sightings.pixel[:, numbers]).points)


def reasons(
    agree: Agreeing, sightings: Sightings, known: Sequence[Camera] | None, rods: Rods | None
) -> dict[int, str]:
    """The faults of cameras without poses, by number, as far as a cause explains them.

    If most cameras see the mirror image of the ones with poses, the latter are mirrored.
    """
    lenses = known or lenses_like(agree, sightings)
    absent = [number for number in range(len(lenses)) if number not in agree.placed]
    others = list(agree.placed.values())
    flipped = {i: mirrored(lenses[i], agree.points, sightings.pixel[:, i], others) for i in absent}
    explained = {i: _flipped(sightings.cameras[i], one) for i, one in flipped.items() if one is not None}
    if len(explained) > len(agree.placed):
        one = next(one for one in flipped.values() if one is not None)
        return {i: _flipped(sightings.cameras[i], one) for i in sorted(agree.placed)}
    for number in (i for i in absent if i not in explained):
        text = _other_reason(number, lenses, agree, sightings, rods)
        if text is not None:
            explained[number] = text
    return explained


def _other_reason(
    number: int, lenses: Sequence[Camera], agree: Agreeing, sightings: Sightings, rods: Rods | None
) -> str | None:
    """Bulbs or lenses that are exchanged."""
    if rods is not None:
        pixel = sightings.pixel[:, number]
        explained = exchanged_bulbs(lenses[number], agree.points, pixel, others_of(rods, len(pixel)))
        if explained is not None:
            return explained
    pair = lens_of_another(number, lenses, agree.points, sightings.pixel)
    return None if pair is None else exchanged(sightings.cameras, pair)


def _flipped(name: str, found: Mirrored) -> str:
    return (
        f"the picture of {name} is mirrored {found.way}: flipped back, {100 * found.share:.0f} % of the "
        "points fit the other cameras; switch mirroring off in the camera or its driver, and record again"
    )


def exchanged(names: Sequence[str], pair: tuple[int, int]) -> str:
    """The sentence on two cameras that see the points through the lens of the other."""
    one, other = (names[number] for number in sorted(pair))
    return (
        f"{one} and {other} are exchanged: each sees the points through the lens that the room gives to the "
        "other; exchange their recordings, or their lenses in the room file"
    )


def lenses_like(agree: Agreeing, sightings: Sightings) -> list[Camera]:
    """Unknown lenses as the cameras that agree have them in the middle, for the size of each picture."""
    placed = agree.placed.values()
    share = np.median([camera.matrix[0, 0] / max(camera.size) for camera in placed])
    bend = np.median([camera.distortion for camera in placed], axis=0)
    lenses = []
    for name, (width, height) in zip(sightings.cameras, sightings.sizes.tolist(), strict=True):
        focal = share * max(width, height)
        matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
        lenses.append(Camera(name, "color", (width, height), matrix, bend, np.eye(3), np.zeros(3)))
    return lenses

"""Why a camera finds no place among the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.adjust import Rods
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.bulbs import confused, others
from followspot_calibrate.wand.hazards.mirrored import mirrored
from followspot_calibrate.wand.hazards.swapped import exchanged_lenses
from followspot_calibrate.wand.rounds import chosen


@dataclass(frozen=True, eq=False)
class Agreeing:
    """The cameras that agree, by number, and the points that they see, (N, 3)."""

    placed: Mapping[int, Camera]
    points: Array


def agreeing_cameras(sightings: Sightings, placed: Mapping[int, Camera]) -> Agreeing:
    """What the cameras that found a place know of the points."""
    numbers = sorted(placed)
    return Agreeing(placed, chosen([placed[i] for i in numbers], sightings.pixel[:, numbers]).points)


def reason(
    number: int, agree: Agreeing, sightings: Sightings, known: Sequence[Camera] | None, rods: Rods | None
) -> str | None:
    """What is wrong with a camera that has no place, and what to do; None where no cause explains it."""
    lens = _lens(number, agree, sightings) if known is None else known[number]
    pixel = sightings.pixel[:, number]
    told = mirrored(lens, agree.points, pixel, list(agree.placed.values()))
    if told is None and rods is not None:
        told = confused(lens, agree.points, pixel, others(rods, len(pixel)))
    if told is None and known is not None:
        pairs = exchanged_lenses(known, agree.points, sightings.pixel)
        told = next((exchanged(sightings.cameras, pair) for pair in pairs if number in pair), None)
    return told


def exchanged(names: Sequence[str], pair: tuple[int, int]) -> str:
    """The sentence on two cameras that see the points through the lens of the other."""
    one, other = names[pair[0]], names[pair[1]]
    return (
        f"{one} and {other} are exchanged: each sees the points through the lens that the room gives to the "
        "other; exchange their recordings, or their lenses in the room file"
    )


def _lens(number: int, agree: Agreeing, sightings: Sightings) -> Camera:
    """An unknown lens as the cameras that agree have it in the middle, for another size of picture."""
    model = next(iter(agree.placed.values()))
    width, height = sightings.sizes[number].tolist()
    focal = np.median([c.matrix[0, 0] / max(c.size) for c in agree.placed.values()]) * max(width, height)
    bend = np.median([c.distortion for c in agree.placed.values()], axis=0)
    matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    name = sightings.cameras[number]
    return replace(model, name=name, size=(width, height), matrix=matrix, distortion=bend)

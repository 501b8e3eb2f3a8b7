"""The two bulbs of a wand: taken for each other in one camera, or not as far apart as they are said to be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.adjust import Rods
from followspot_calibrate.similarity import spread
from followspot_calibrate.wand.hazards.support import CLEARLY, ENOUGH, support
from followspot_calibrate.wand.rods import measured
from followspot_calibrate.wand.rounds import SIGMAS, RobustAdjustment

SCATTER = 0.03
"""Spread of the measured lengths over the length of the wand that gives a warning."""
ROOM = (0.3, 100.0)
"""Smallest and largest distance of cameras from their middle that a length in metres gives, m."""
CONFUSED = 0.05
"""Share of a camera's points that are the other bulb that gives a warning."""


def exchanged_bulbs(camera: Camera, points: Array, pixel: Array, other: Array) -> str | None:
    """The fault if a camera without a pose has the bulbs exchanged; None if it does not.

    points: (N, 3); pixel: (N, 2) px of this camera; other: (N,) the row of the other bulb, -1 without one.
    """
    rows = np.flatnonzero(other >= 0)
    turned = support(camera, points[rows], pixel[other[rows]])
    if turned.share < max(ENOUGH, CLEARLY * support(camera, points, pixel).share):
        return None
    return (
        f"{camera.name} takes the two bulbs of the wand for each other: exchanged, "
        f"{100 * turned.share:.0f} % of its points fit; exchange 0 and 1 of the column point for it"
    )


def others_of(rods: Rods, rows: int) -> Array:
    """The row of the other bulb at the same moment, (N,); -1 without one."""
    other = np.full(rows, -1)
    other[rods.first], other[rods.second] = rods.second, rods.first
    return other


def length_warnings(adjusted: RobustAdjustment, rods: Rods, pixel: Array) -> list[str]:
    """Warnings from the measured lengths. adjusted: in m, as the length has it; pixel: (N, C, 2) px."""
    return [
        *_taken_for_each_other(adjusted, rods, pixel),
        *_unlikely(adjusted.cameras, adjusted.points, rods),
    ]


def _taken_for_each_other(adjusted: RobustAdjustment, rods: Rods, pixel: Array) -> list[str]:
    """Cameras that sometimes confuse the two bulbs."""
    other, warnings = others_of(rods, len(pixel)), []
    rows = np.flatnonzero(other >= 0)
    for number, camera in enumerate(adjusted.cameras):
        away = np.linalg.norm(project(camera, adjusted.points[other[rows]]) - pixel[rows, number], axis=1)
        wrong = ~adjusted.used[rows, number] & (away < SIGMAS * adjusted.sigma)
        share = wrong.sum() / max(1, np.isfinite(pixel[rows, number, 0]).sum())
        if share > CONFUSED:
            warnings.append(
                f"{camera.name} takes the bulbs of the wand for each other in {100 * share:.0f} % of its "
                "points, which were left out: use bulbs of two colours or sizes"
            )
    return warnings


def _unlikely(cameras: Sequence[Camera], points: Array, rods: Rods) -> list[str]:
    """A wand that is not rigid, or a room that is too large or too small."""
    lengths, warnings = measured(points, rods), []
    length = float(np.max(rods.length))
    scatter = float(np.nanpercentile(np.abs(lengths - length), 68)) if np.isfinite(lengths).any() else 0.0
    if scatter > SCATTER * length:
        warnings.append(
            f"the wand is {1000 * length:.0f} mm long, but measured that within {1000 * scatter:.0f} mm "
            "only: are its bulbs fixed, and told apart in every camera?"
        )
    size = spread([camera.center for camera in cameras])
    if not ROOM[0] < size < ROOM[1]:
        warnings.append(
            f"by the length of the wand the cameras are {size:.3g} m from their middle: "
            "is --length in metres?"
        )
    return warnings

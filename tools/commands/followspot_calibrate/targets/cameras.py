"""Agreement of the cameras about the targets in their clips, and the correction if they disagree."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Room
from followspot.errors import FollowspotError
from followspot_calibrate.adjust import Progress
from followspot_calibrate.refine.solving import Refinement, refine
from followspot_calibrate.target_sightings import TargetSightings, find_target_sightings
from followspot_calibrate.wand.rounds import RAYLEIGH, RobustAdjustment, chosen

FEWEST = 3
"""Cameras that can be held against each other."""
FITTING = 0.5
"""Share of a camera's sightings that must fit the others'; else it is not just slightly off."""
AGREEING = 1.0
"""Largest error, beyond that of lamps and patches off the middle of a target, of cameras that agree."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """Agreement of the clips with the cameras: a correction, or the reason why there is none."""

    correction: Refinement | None = None
    problem: str = ""


def agreement(room: Room, clips: Path, progress: Progress | None = None) -> Agreement:
    """Compares cameras by the places at which they see each target in the same frame of its clip.

    Cameras with clock offsets take their frames at different moments, which is no disagreement.
    """
    cameras = list(room.cameras.values())
    if len(cameras) < FEWEST or any(camera.clock_offset for camera in cameras):
        return Agreement()
    try:
        sightings = find_target_sightings(clips, cameras, progress)
    except FollowspotError as reason:
        return Agreement(problem=f"cameras were not held against each other: {reason}")
    given = chosen(cameras, sightings.pixel)
    if apart := elsewhere(given, sightings):
        cause = (
            "the clips of a target do not begin at the same moment, a camera has moved, or a lamp lights the "
            "target from one side"
        )
        return Agreement(
            problem=f"{apart} and the other cameras see the targets at different places: {cause}"
        )
    if excess(given, sightings) <= AGREEING:
        return Agreement()
    try:
        found = refine(cameras, sightings, room.planes, progress)
    except FollowspotError as reason:
        return Agreement(problem=f"{disagreement(given)}, and clips cannot correct them: {reason}")
    if excess(found.after, sightings) > AGREEING:
        left = f"{median_px(found.after):.2f} px are left when they are corrected by the clips"
        cause = "they are not synchronised (`followspot calibrate clocks`), or must be calibrated again"
        return Agreement(problem=f"{disagreement(given)}, and {left}: {cause}")
    return Agreement(found)


def elsewhere(adjusted: RobustAdjustment, sightings: TargetSightings) -> str:
    """Names of the cameras that see most targets at other places than the rest, with commas."""
    seen = np.isfinite(sightings.pixel[..., 0]).sum(axis=0)
    fitting = adjusted.used.sum(axis=0) >= FITTING * seen
    return ", ".join(c.name for c, fits in zip(adjusted.cameras, fitting, strict=True) if not fits)


def excess(adjusted: RobustAdjustment, sightings: TargetSightings) -> float:
    """Median reprojection error over that of sightings that are as good as they can be."""
    return float(np.nanmedian(adjusted.distance / sightings.sigma[:, None])) / RAYLEIGH


def disagreement(given: RobustAdjustment) -> str:
    """Errors of the cameras in the room file."""
    return f"cameras contradict each other about the targets by {median_px(given):.2f} px"


def median_px(adjusted: RobustAdjustment) -> float:
    """Median reprojection error, px."""
    return float(np.nanmedian(adjusted.distance))

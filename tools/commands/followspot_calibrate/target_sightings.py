"""Sightings of single targets in clips of a room's cameras: points for other calibrations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_balls.templates.from_clip import COLOR_EDGE, INFRARED_EDGE
from followspot_balls.templates.glowing_spot import Spot, brightness, glowing
from followspot_calibrate.adjust import Progress
from followspot_calibrate.clips import MOST_FRAMES, folders_of, read_frames
from followspot_cameras.recordings import find_recordings

OFF_MIDDLE = 0.03
"""Distance between the middle of the bright part and the middle of the target, one sigma over its width.

Lamps and reflective patches are not in the middle, and infrared cameras see other ones than colour cameras.
That shifts all sightings of a camera alike, so averaging does not help: it counts for each sighting.
"""
DIM = 0.25
"""Level over that of the bright part down to which pixels around it belong to the target, which a lamp may
light from one side."""
WIDEST = 4.0
"""Largest area of these over that of the bright part; more is other light."""


@dataclass(frozen=True, eq=False)
class TargetSightings:
    """Targets at N moments as C cameras saw them.

    pixel: (N, C, 2) px with lens distortion, NaN if not seen; sigma: (N,) px, of one coordinate.
    """

    pixel: Array
    sigma: Array


def find_target_sightings(
    clips: Path, cameras: Sequence[Camera], progress: Progress | None = None
) -> TargetSightings:
    """The target in CLIPS/<target>/<camera>.mkv; equal numbers of frames are equal moments.

    A camera whose clip is absent or shows no target has no sightings. Raises FollowspotError if no moment
    has two.
    """
    found = []
    folders = folders_of(clips, "target")
    for number, folder in enumerate(folders):
        if progress is not None:
            progress(f"target {folder.name}", number / len(folders))
        found.append(_places(folder, cameras))
    pixel, width, aside = (np.concatenate(parts) for parts in zip(*found, strict=True))
    rows = np.isfinite(width).sum(axis=1) >= 2
    if not rows.any():
        raise FollowspotError(f"{clips}: no target is seen by two cameras at the same frame of their clips")
    middle = OFF_MIDDLE * np.nanmean(width[rows], axis=1)
    return TargetSightings(pixel[rows], np.maximum(middle, np.nanmean(aside[rows], axis=1)))


def _places(folder: Path, cameras: Sequence[Camera]) -> tuple[Array, Array, Array]:
    """Of one target: (F, C, 2) px, the width of its bright part in each picture, and how far the middle of
    that is from the middle of all that is lit, at the mean of the clip, (F, C) px; NaN if it is not seen.
    """
    pixel, lit_middle = np.full((2, MOST_FRAMES, len(cameras), 2), np.nan)
    width = np.full((MOST_FRAMES, len(cameras)), np.nan)
    recordings = find_recordings(folder, [camera.name for camera in cameras])
    for number, camera in enumerate(cameras):
        for spot, lit in _spots(recordings[camera.name], camera) if camera.name in recordings else ():
            pixel[spot.frame, number] = _middle(spot.inside)
            width[spot.frame, number] = np.sqrt(4 / np.pi * spot.area)
            lit_middle[spot.frame, number] = _middle(lit)
    seen = np.isfinite(width)
    # What differs from picture to picture is noise, not the light of a lamp.
    mean = np.nansum(pixel - lit_middle, axis=0) / np.maximum(seen.sum(axis=0), 1)[:, None]
    return pixel, width, np.where(seen, np.linalg.norm(mean, axis=1), np.nan)


def _middle(mask: Array) -> Array:
    """The mean place of the pixels of a mask, (2,) px."""
    return np.array([axis.mean() for axis in np.nonzero(mask)[::-1]])


def _spots(recording: Path, camera: Camera) -> list[tuple[Spot, Array]]:
    """The target in each frame that shows it, with all of it that is lit; none if the clip shows none."""
    frames = read_frames(recording, camera, MOST_FRAMES)
    edge = COLOR_EDGE if camera.kind == "color" else INFRARED_EDGE
    levels = [brightness(frame) for frame in frames]
    try:
        return [(spot, _lit(levels[spot.frame], spot)) for spot in glowing(levels, edge)]
    except ValueError:
        return []


def _lit(level: Array, spot: Spot) -> Array:
    """The pixels of a target down to `DIM`, (H, W) bool; its bright part if other light touches it."""
    _, label = cv2.connectedComponents((level >= DIM * spot.level).view(np.uint8), connectivity=8)
    lit = np.asarray(label == label[spot.inside].max())
    return lit if spot.area <= lit.sum() <= WIDEST * spot.area else spot.inside

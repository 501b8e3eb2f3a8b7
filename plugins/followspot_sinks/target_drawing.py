"""Targets in a picture: where they were sought and found, and where they are (Jin & Qian 2008, figure 6)."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera, Target
from followspot.tracking import LOST, Blobs, Forecast, Tracks
from followspot_sinks.pose_drawing import images
from followspot_sinks.primitives import Color, circle, label, visible

PALETTE = ((66, 135, 245), (80, 200, 90), (240, 120, 60), (200, 90, 220), (60, 210, 230), (150, 150, 250))
"""BGR, for one person or target without a colour after the other."""
BLOB, REGION = (40, 40, 255), (0, 230, 255)
RADIUS = 0.05
"""Of a target that the room does not have, m."""
SMALLEST = 3.0
"""Smallest radius of a circle, px."""
BOLD = 2
"""Width of the line of a track, px."""
HUES = 256


def target_color(target: Target, number: int) -> Color:
    """The most frequent hue of the target's templates; without one, a colour of the palette."""
    histograms = list(target.hue_histogram.values())
    if not histograms or not np.any(histograms):
        return PALETTE[number % len(PALETTE)]
    mean = np.mean(histograms, axis=0)
    hue = int((mean.argmax() + 0.5) * HUES / len(mean))
    b, g, r = cv2.cvtColor(np.array([[[hue, 220, 255]]], np.uint8), cv2.COLOR_HSV2BGR_FULL)[0, 0].tolist()
    return b, g, r


def draw_tracks(picture: Array, camera: Camera, tracks: Tracks, targets: Sequence[Target]) -> None:
    """A bold circle as large as the target, and its name."""
    for number, xyz in zip(tracks.target.tolist(), tracks.xyz, strict=True):
        known = targets[number] if 0 <= number < len(targets) else Target(str(number), RADIUS)
        color = target_color(known, number)
        for middle, rim in images(camera, np.array([xyz, xyz + known.radius * camera.rotation[0]])):
            radius = max(SMALLEST, float(np.linalg.norm(rim - middle)))
            circle(picture, middle, radius, color, BOLD)
            if visible(picture, middle):
                label(picture, middle + np.array([radius, -radius]), known.name, color)


def draw_blobs(picture: Array, blobs: Blobs) -> None:
    """A slim circle with the area of each blob."""
    for pixel, area in zip(blobs.pixel, blobs.area.tolist(), strict=True):
        circle(picture, pixel, max(SMALLEST, float(np.sqrt(area / np.pi))), BLOB)


def draw_search_regions(
    picture: Array, camera: Camera, forecast: Forecast, minimum: float, scale: float
) -> None:
    """The circles in which targets are sought; a lost target has none.

    minimum: smallest radius, px; scale: radius over the travel between the last two estimates (eq. 3).
    """
    known = forecast.state != LOST
    center, last, before = (
        project(camera, place[known]) for place in (forecast.xyz, forecast.last, forecast.before)
    )
    travel = np.linalg.norm(last - before, axis=1)
    radius = np.where(travel > minimum, scale * travel, minimum)
    for middle, reach in zip(center, radius.tolist(), strict=True):
        if np.isfinite(middle).all():
            circle(picture, middle, reach, REGION)

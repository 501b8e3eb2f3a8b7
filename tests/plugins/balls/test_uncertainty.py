"""The whole tracker on pictures: errors are as large as tracks say, also of balls that are hidden in part."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.recorded import track
from tests.plugins.balls.scene import SIZE, make_room, picture

from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.stage import Stage
from followspot.tracking import Frame
from followspot_accuracy.targets.metrics import within_ellipsoid
from followspot_balls.bundle_fusion import Bundle
from followspot_balls.mean_shift import MeanShift

FRAMES = 60
SHAKE = 0.2
"""Sigma of the shift of each picture along each axis, px."""
BAR = 9
"""Half the width of the bar that swings before each camera, px: wider than a ball."""


def performance(rng: np.random.Generator) -> Array:
    """Two balls that swing through each other's space: (FRAMES, 2, 3) m."""
    phase, speed = rng.uniform(0, 2 * np.pi, (2, 3)), rng.uniform(1.5, 4.0, (2, 3))
    swing = np.sin(speed * np.arange(FRAMES)[:, None, None] / 30 + phase)
    return np.asarray([0.0, 0.0, 1.0] + swing * [0.35, 0.35, 0.25])


def filmed(places: Array, rng: np.random.Generator) -> Iterator[dict[str, Frame]]:
    """The frames of cameras that shake, behind bars that swing."""
    cameras = make_room().cameras
    middle, speed = rng.uniform(30, 130, len(cameras)), rng.uniform(1.5, 4.5, len(cameras))
    for number, (red, green) in enumerate(places):
        bars = (middle + 35 * np.sin(speed * number / 30)).astype(int)
        frames = {}
        for (name, camera), bar in zip(cameras.items(), bars.tolist(), strict=True):
            matrix = camera.matrix.copy()
            matrix[:2, 2] += rng.normal(0, SHAKE, 2)
            shaken = replace(camera, matrix=matrix)
            pixels = picture(shaken, {"red": red, "green": green}).pixels.astype(int)
            pixels[:, np.abs(np.arange(SIZE[0]) - bar) < BAR] = 0
            pixels += rng.integers(-6, 7, pixels.shape)
            frames[name] = seal(Frame(camera=name, pixels=np.clip(pixels, 0, 255).astype(np.uint8)))
        yield frames


@pytest.mark.parametrize("fusion", [MeanShift, Bundle])
def test_errors_of_balls_that_are_hidden_in_part_are_within_what_tracks_say(fusion: type[Stage]) -> None:
    """95 % should be, and the median of the squared distances be 2.4.

    Three seeds give 92 to 95 % and 1.8 to 2.7 with both fusions; a constant sigma of 8 mm gives medians of
    0.6 to 0.8.
    """
    rng = np.random.default_rng(2)
    places = performance(rng)
    errors, sigmas = [], []
    for output, true in zip(track(make_room(), list(filmed(places, rng)), fusion), places, strict=True):
        errors.append(output.tracks.xyz - true[output.tracks.target])
        sigmas.append(output.tracks.sigma)
    error, sigma = np.concatenate(errors), np.concatenate(sigmas)
    assert len(error) > 1.9 * FRAMES
    assert 0.88 < within_ellipsoid(error, sigma).mean() < 0.99
    assert 1.3 < np.median(np.square(error / sigma).sum(axis=1)) < 3.6

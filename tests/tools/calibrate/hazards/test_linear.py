"""A wand that was waved along a line is refused: such motion does not determine the cameras."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, waved_room

from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot_calibrate.wand.hazards.linear import on_a_line
from followspot_calibrate.wand.solving import solve

ALONG_A_LINE = "the points lie along one line, which determines no pose.*wave up and down"


def line_room(way: tuple[float, float, float], shake: float, outliers: float = 0.0) -> MadeRoom:
    """A wand on a line through the middle of a room. way: half the line, shake: one sigma around it, m."""
    room, random = waved_room(4, 300), np.random.default_rng(5)
    walk = np.cumsum(random.normal(size=(300, 3)), axis=0)
    walk = (walk - walk.mean(axis=0)) / walk.std()
    points = [0, 0, 1] + np.outer(np.sin(np.arange(300) * 0.13), way) + shake * walk
    pixel = np.stack([project(camera, points) for camera in room.cameras], axis=1)
    pixel += random.normal(0, 0.4, pixel.shape)
    wrong = random.random(pixel.shape[:2]) < outliers
    pixel[wrong] = random.uniform([0, 0], [640, 480], (int(wrong.sum()), 2))
    pixel[((pixel < 0) | (pixel > [640, 480])).any(axis=2)] = np.nan
    return replace(room, points=points, sightings=replace(room.sightings, pixel=pixel))


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(
    ("way", "shake", "outliers"),
    [
        ((1.5, 0, 0), 0.0, 0.0),
        ((1.5, 0, 0), 0.005, 0.2),
        ((1.2, 1.0, 0.6), 0.0, 0.2),
        ((1.2, 1.0, 0.6), 0.01, 0.0),
    ],
)
def test_linear_motion_is_refused(
    way: tuple[float, float, float], shake: float, outliers: float, known: bool
) -> None:
    room = line_room(way, shake, outliers)
    with pytest.raises(FollowspotError, match=ALONG_A_LINE):
        solve(room.sightings, room.cameras if known else None)


def test_a_full_room_is_on_no_line_whatever_else_is_seen() -> None:
    for seed in range(5):
        room = waved_room(5, 200, outliers=0.2, seed=seed)
        assert not on_a_line(room.sightings.pixel, 1)
        assert not on_a_line(room.sightings.pixel, 2)


def test_one_camera_may_see_all_on_a_line() -> None:
    pixel = waved_room(4, 100).sightings.pixel
    flat = pixel.copy()
    flat[:, 0, 1] = 240
    assert not on_a_line(flat)
    flat[:, 1:3, 1] = 240
    assert on_a_line(flat)

"""The yardstick of benchmarks is a tracker: without that, a ratio to it would mean nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benching import plain_tracker
from followspot.messages import Array
from followspot.room import Room
from followspot.room_file import load
from followspot_sim.parameters import CameraParams
from followspot_sim.rendering.picture import Picture
from followspot_sim.visibility import truth_flags, visible_fraction
from followspot_sim.world import setting, world_of

ROOT = Path(__file__).parents[3]
FIRST, FRAMES = 300, 8
"""Frames in which cameras of both kinds see half of every ball and more: the plain tracker takes no parts."""


@pytest.fixture(scope="module")
def room() -> Room:
    return load(ROOT / "graphs/rooms/simulated6.yaml")


@pytest.fixture(scope="module")
def params(room: Room) -> CameraParams:
    source = room.cameras["cam0"].source
    assert source is not None
    return CameraParams(**source.params)


@pytest.fixture(scope="module")
def frames(room: Room, params: CameraParams) -> dict[str, list[Array]]:
    shown: dict[str, list[Array]] = {}
    for name, camera in room.cameras.items():
        picture = Picture(params, room, camera)
        shown[name] = [np.empty(picture.shape, np.uint8) for _ in range(FRAMES)]
        for k, pixels in enumerate(shown[name]):
            picture.render(FIRST + k, pixels)
    return shown


def test_it_finds_the_balls_among_projections(
    room: Room, params: CameraParams, frames: dict[str, list[Array]]
) -> None:
    world = world_of(setting(params, room))
    radii = np.array([target.radius for target in room.targets.values()])
    cameras = list(room.cameras.values())
    for k in range(FRAMES):
        assert truth_flags(visible_fraction(cameras, world.scene(FIRST + k), radii), cameras)[2].all()
    errors = [
        float(np.linalg.norm(xyz - world.scene(FIRST + k).balls[list(room.targets).index(name)]))
        for k, found in enumerate(plain_tracker.run(room, frames))
        for name, xyz in found.items()
    ]
    assert len(errors) > 0.8 * FRAMES * len(room.targets)
    assert np.median(errors) < 0.01
    assert np.max(errors) < 0.15

"""`calibrate wand` with lenses of any model, and with pixels that are not square."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, waved_room
from tests.tools.calibrate.wand_errors import FREE_MM, KNOWN_MM, NOISE, differences

from followspot.geometry import project
from followspot.room import LensModel
from followspot_calibrate.wand.solving import solve

LENSES: dict[LensModel, list[float]] = {
    "rational": [0.54, -2.62, 0.0007, -0.0002, 1.53, 0.42, -2.43, 1.45],
    "fisheye": [0.05, -0.01, 0.004, -0.001],
}


def room_through(model: LensModel, lens: list[float] | None = None, aspect: float = 1.0) -> MadeRoom:
    """A waved room seen through other lenses. aspect: height of the focal length over its width."""
    room = waved_room(4, 300)
    cameras = []
    for camera in room.cameras:
        matrix = camera.matrix * [[1.0], [aspect], [1.0]]
        size = (camera.size[0], round(camera.size[1] * aspect))
        distortion = camera.distortion if lens is None else np.array(lens)
        cameras.append(replace(camera, model=model, distortion=distortion, matrix=matrix, size=size))
    pixel = np.stack([project(camera, room.points) for camera in cameras], axis=1)
    pixel += np.random.default_rng(1).normal(0, NOISE, pixel.shape)
    sizes = np.array([camera.size for camera in cameras])
    pixel[((pixel < 0) | (pixel > sizes)).any(axis=2)] = np.nan
    return replace(room, cameras=tuple(cameras), sightings=replace(room.sightings, pixel=pixel, sizes=sizes))


@pytest.mark.parametrize("model", ["rational", "fisheye"])
def test_known_lenses_of_other_models_are_kept_and_placed(model: LensModel) -> None:
    room = room_through(model, LENSES[model])
    solved = solve(room.sightings, room.cameras)
    assert differences(solved, room)[0].max() < KNOWN_MM
    for found, true in zip(solved.adjusted.cameras, room.cameras, strict=True):
        assert (found.model, found.distortion.tolist()) == (model, true.distortion.tolist())


@pytest.mark.parametrize("aspect", [0.8, pytest.param(1.25, marks=pytest.mark.thorough)])
def test_pixels_that_are_not_square_are_found(aspect: float) -> None:
    room = room_through("pinhole", aspect=aspect)
    solved = solve(room.sightings, None)
    assert differences(solved, room)[0].max() < FREE_MM
    for camera in solved.adjusted.cameras:
        assert camera.matrix[1, 1] / camera.matrix[0, 0] == pytest.approx(aspect, rel=0.03), (
            "as focal lengths are found"
        )


def test_pixels_that_are_square_stay_so() -> None:
    solved = solve(waved_room(4, 300).sightings, None)
    for camera in solved.adjusted.cameras:
        assert camera.matrix[1, 1] == camera.matrix[0, 0]

"""What people hide of balls: the picture shows of a ball what the truth calls visible."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from followspot import room_file
from followspot_sim.parameters import SimParams
from followspot_sim.rendering.camera_rays import CameraRays, camera_rays
from followspot_sim.rendering.projected_scene import projected_scene
from followspot_sim.rendering.screen import rays_of
from followspot_sim.visibility import visible_fraction
from followspot_sim.world import Scene, setting, world_of

ROOM = room_file.load(Path(__file__).parents[3] / "graphs/rooms/simulated.yaml")
VIEWS = {name: camera_rays(camera, rays_of(camera)) for name, camera in ROOM.cameras.items()}
EVERY = pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
BALL = np.array([0.0, 0.0, 1.0])
RADIUS = np.array([0.0762])


def shares(view: CameraRays, scene: Scene) -> tuple[float, float]:
    """Visible share of the one ball of a scene, in the picture and by the truth."""
    shown = projected_scene(view, scene, RADIUS).balls.shown
    return float(shown[0]), float(visible_fraction([view.camera], scene, RADIUS)[0, 0])


def with_limb(view: CameraRays, ends: np.ndarray, thick: float) -> tuple[float, float]:
    return shares(view, Scene(0.0, BALL[None], ends[None], np.array([thick]), np.zeros(1, int)))


def towards(view: CameraRays) -> np.ndarray:
    """Unit vector from the ball to the camera."""
    away = view.camera.center - BALL
    return away / np.linalg.norm(away)


def beside(view: CameraRays) -> np.ndarray:
    """Unit vector across the line of sight, level."""
    across = np.cross(towards(view), [0, 0, 1])
    return across / np.linalg.norm(across)


@EVERY
def test_with_any_cast_the_picture_shows_of_each_ball_what_the_truth_says(view: CameraRays):
    world = world_of(setting(SimParams(seed=7), ROOM))
    found = []
    for frame in range(0, 1200, 10):
        scene = world.scene(frame)
        alone = [replace(scene, balls=ball[None]) for ball in scene.balls]
        found += [shares(view, one) for one in alone]
    shown, true = np.array(found).T
    partly = (true > 0.02) & (true < 0.98)
    assert partly.sum() > 20
    error = (shown - true)[partly]
    assert abs(error.mean()) < 0.02
    assert np.abs(error).max() < 0.1


@EVERY
def test_a_pole_hides_what_is_behind_it_and_not_what_is_before_or_beside_it(view: CameraRays):
    upright = np.array([[0, 0, -0.6], [0, 0, 0.6]])
    for distance, side, expected in ((0.5, 0.0, 0.0), (-0.5, 0.0, 1.0), (0.5, 0.4, 1.0)):
        pole = BALL + upright + distance * towards(view) + side * beside(view)
        shown, true = with_limb(view, pole, 0.1)
        assert true == expected
        assert shown == pytest.approx(expected, abs=0.02)
    shown, true = with_limb(view, BALL + upright + 0.5 * towards(view) + 0.1 * beside(view), 0.1)
    assert 0.1 < true < 0.9
    assert shown == pytest.approx(true, abs=0.05)


@EVERY
def test_a_ball_that_comes_out_of_a_bag_turns_up_gradually(view: CameraRays):
    out = beside(view) + towards(view)
    found = []
    for way in np.linspace(0, 0.16, 321):
        bag = BALL - way * out + np.array([[0, 0, -0.06], [0, 0, 0.04]])
        found.append(with_limb(view, bag, 0.13))
    shown, true = np.array(found).T
    assert (shown[0], shown[-1]) == (pytest.approx(0, abs=0.02), pytest.approx(1, abs=0.02))
    assert np.abs(shown - true).max() < 0.12
    assert np.abs(np.diff(shown)).max() < 0.12


def test_the_visible_share_is_all_that_is_left_when_two_limbs_cover_a_ball():
    view = VIEWS["cam2"]
    upright = np.array([[0, 0, -0.6], [0, 0, 0.6]])
    poles = [BALL + upright + 0.5 * towards(view) + side * beside(view) for side in (0.13, -0.13)]
    scene = Scene(0.0, BALL[None], np.array(poles), np.full(2, 0.1), np.zeros(2, int))
    left = 1 - sum(1 - with_limb(view, pole, 0.1)[0] for pole in poles)
    assert 0.2 < left < 0.8
    assert shares(view, scene)[0] == pytest.approx(left, abs=0.03)

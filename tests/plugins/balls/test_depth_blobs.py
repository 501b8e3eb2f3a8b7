"""Balls in depth images."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, blobs_of, forecast_at, look_at

import followspot as fs
from followspot import Context, InputError, Room, room_file
from followspot.geometry import depth_rays
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.room import Camera, Target
from followspot.testing import check_stage, tiny_room
from followspot.tracking import LOST, TRACKED, Candidates, DepthImage, Forecast
from followspot_balls.depth_blobs import DepthBlobs
from followspot_balls.gather import Gather
from followspot_sim.rendering.ray_casting import first_hit

ROOMS = Path(__file__).parents[3] / "graphs/rooms"
FLOOR = np.array([0.0, 0.0, 1.0, 0.0])
RED, GREEN = np.array([0.0, 0.0, 1.0]), np.array([0.5, 0.3, 1.2])


def make_room(**radii: float) -> Room:
    """Two depth cameras 4 m from balls of these radii, by default one red ball."""
    cameras = [look_at("left", "depth", (3.0, 0.0, 3.0)), look_at("right", "depth", (-3.0, 0.5, 3.0))]
    targets = {name: Target(name, radius) for name, radius in (radii or {"red": RADIUS}).items()}
    return Room("depth", {c.name: c for c in cameras}, {"floor": FLOOR}, targets)


def image(camera: Camera, *capsules: tuple[np.ndarray, np.ndarray, float], noise: float = 0.0) -> DepthImage:
    """A floor and capsules, which are balls if their ends are equal."""
    rays = depth_rays(camera)
    stretch = np.linalg.norm(rays, axis=2)
    depth = -camera.center[2] / np.minimum(rays[..., 2], -1e-9)
    for one, other, radius in capsules:
        reach = first_hit(camera.center, rays / stretch[..., None], np.array([one, other]), radius)
        depth = np.minimum(depth, reach / stretch)
    depth[depth > 20] = 0
    depth += np.random.default_rng(0).normal(0, 1, depth.shape) * noise
    return DepthImage(camera.name, depth.astype(np.float32))


def ball(place: np.ndarray, radius: float = RADIUS) -> tuple[np.ndarray, np.ndarray, float]:
    return place, place, radius


def at(*offset: float) -> np.ndarray:
    """A place beside the red ball."""
    return RED + np.array(offset)


def stage(room: Room, camera: str = "left", **params: object) -> DepthBlobs:
    made = DepthBlobs(Context.serving(room.cameras[camera], room), **params)
    made.setup()
    return made


def found(
    *capsules: tuple[np.ndarray, np.ndarray, float], forecast: Forecast | None = None, noise: float = 0.0
) -> Candidates:
    room = make_room()
    return seal(stage(room).process(image(room.cameras["left"], *capsules, noise=noise), forecast))


@pytest.mark.parametrize("place", [RED, GREEN, np.array([-0.6, 0.5, RADIUS]), np.array([1.5, 0.3, 1.6])])
def test_a_ball_is_found_at_its_centre(place: np.ndarray) -> None:
    candidates = found(ball(place), noise=0.004)
    assert len(candidates.xyz) == 1
    assert np.linalg.norm(candidates.xyz[0] - place) < 0.008
    assert candidates.evident.all()
    assert candidates.targets.all()
    camera = make_room().cameras["left"]
    shown = camera.projection @ [*candidates.xyz[0], 1.0]
    assert np.allclose(candidates.xy, shown[:2] / shown[2])


def test_a_ball_is_told_from_what_has_another_size_or_shape() -> None:
    left, right = at(0.0, -4.0, 0.0), at(0.0, 4.0, 0.0)
    others = ball(RED, 1.5 * RADIUS), ball(RED, RADIUS / 2), (left, right, RADIUS), (left, right, 0.04)
    for other in others:
        assert not found(other).evident.any()


def test_a_ball_in_a_hand_is_found_and_the_arm_is_none() -> None:
    elbow = at(0.0, 0.35, -0.1)
    candidates = found(ball(RED), (at(0.0, 0.07, -0.03), elbow, 0.045), noise=0.004)
    (place,) = candidates.xyz[candidates.evident]
    assert np.linalg.norm(place - RED) < 0.01


def test_a_hidden_part_and_unmeasured_pixels_cost_no_ball() -> None:
    room = make_room()
    camera = room.cameras["left"]
    shot = image(camera, ball(RED))
    depth = shot.depth.copy()
    rng = np.random.default_rng(1)
    depth[rng.uniform(size=depth.shape) < 0.1] = 0
    depth[rng.uniform(size=depth.shape) < 0.1] = np.nan
    (place,) = stage(room).process(DepthImage("left", depth)).xyz
    assert np.linalg.norm(place - RED) < 0.005


def gathered(room: Room, *parts: Candidates, **rest: object) -> Candidates:
    gather = Gather(Context(room=room))
    gather.setup()
    return seal(gather.process(parts, **rest))


def whose(candidates: Candidates) -> dict[tuple[bool, ...], np.ndarray]:
    return {tuple(row): xyz for row, xyz in zip(candidates.targets.tolist(), candidates.xyz, strict=True)}


def test_targets_of_one_radius_are_known_by_exclusion_or_not_at_all() -> None:
    room = make_room(red=RADIUS, green=RADIUS, large=2 * RADIUS)
    shot = image(room.cameras["left"], ball(RED), ball(GREEN), ball(np.array([-0.6, -0.6, 0.5]), 2 * RADIUS))
    nobody = gathered(room, stage(room).process(shot))
    assert nobody.targets.tolist() == [[False, False, True]]
    known = replace(forecast_at([RED, RED, RED]), state=np.array([TRACKED, LOST, LOST], np.uint8))
    found = whose(gathered(room, stage(room).process(shot, known), forecast=known))
    assert set(found) == {(True, False, False), (False, True, False), (False, False, True)}
    assert np.linalg.norm(found[False, True, False] - GREEN) < 0.01


def test_a_colour_camera_names_what_a_depth_camera_finds() -> None:
    room = make_room(red=RADIUS, green=RADIUS)
    color = look_at("color", "color", (0.0, 3.0, 3.0))
    room = replace(room, cameras={**room.cameras, "color": color})
    found = stage(room).process(image(room.cameras["left"], ball(RED), ball(GREEN)))
    assert found.targets.all()
    blobs = blobs_of(color, [tuple(RED), tuple(GREEN)], [[True, False], [False, True]])
    named = gathered(room, found, blobs=(blobs,))
    assert named.labelled.all()
    assert np.linalg.norm(whose(named)[True, False] - RED) < 0.01
    assert np.linalg.norm(whose(named)[False, True] - GREEN) < 0.01
    infrared = replace(blobs, camera="left")  # no colour camera, so its blobs are no names
    aside = blobs_of(color, [(0.0, 0.5, 1.0)], [[True, False]])
    for other in (infrared, aside):
        assert not len(gathered(room, found, blobs=(other,)).xyz)


def test_what_touches_other_things_is_a_ball_only_at_its_forecast() -> None:
    arms = (RED, at(0.0, 0.4, 0.0), 0.04), (RED, at(0.0, 0.0, 0.4), 0.04)
    both = ball(RED), *arms
    here = forecast_at([RED])
    aside = forecast_at([at(0.0, 0.0, 0.1)])
    assert not found(*both).targets.any()
    assert np.linalg.norm(found(*both, forecast=here).xyz[0] - RED) < 0.01
    assert not found(*both, forecast=aside).targets.any()


def test_the_background_is_learnt_where_the_room_has_no_planes() -> None:
    room = replace(make_room(), planes={})
    camera = room.cameras["left"]
    cupboard = (np.array([-1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.5]), RADIUS)
    learning = stage(room, learning_frames=2)
    moving = (image(camera, cupboard, ball(place)) for place in (RED, GREEN))
    assert [len(learning.process(shot).xyz) for shot in moving] == [0, 0]
    again = stage(room, learning_frames=2)
    again.restore(learning.state())
    for one in (learning, again):
        (place,) = one.process(image(camera, cupboard, ball(RED))).xyz
        assert np.linalg.norm(place - RED) < 0.005
        assert not len(one.process(image(camera, cupboard)).xyz)


def test_an_image_of_another_size_is_one_clear_error() -> None:
    with pytest.raises(InputError, match="depth images of 5x4 px, and camera left has 160x120"):
        stage(make_room()).process(DepthImage("left", np.ones((4, 5), np.float32)))


def test_candidates_of_several_cameras_are_one_message() -> None:
    room = make_room()
    shots = {name: image(camera, ball(RED)) for name, camera in room.cameras.items()}
    left, right = (stamped(stage(room, name).process(shots[name]), Header(name, 0, 0)) for name in shots)
    gather = Gather(Context(room=room))
    gather.setup()
    both = gathered(room, left, right)
    assert both.view.tolist() == [[0, 0], [1, 1]]
    assert np.allclose(both.xyz, RED, atol=0.005)
    alone = replace(right, cameras=("right",), view=np.zeros((1, 2), np.int32))
    assert gather.process((left, alone)).view.tolist() == [[0, 0], [1, 1]]
    assert gather.process((alone,)).view.tolist() == [[1, 1]]
    assert gather.process(()).targets.shape == (0, 1)


@pytest.mark.parametrize("learning_frames", [0, 3])
def test_they_keep_the_promises_of_stages(learning_frames: int) -> None:
    room = tiny_room("depth", "depth")
    check_stage(DepthBlobs, room=room, messages=200, learning_frames=learning_frames)
    check_stage(Gather, room=room, messages=200)


@pytest.mark.parametrize(
    ("cameras", "coverage"), [(2, 0.9), pytest.param(1, 0.6, marks=pytest.mark.thorough)]
)
def test_depth_cameras_track_the_balls_of_the_simulated_room(
    tmp_path: Path, cameras: int, coverage: float
) -> None:
    room = room_file.load(ROOMS / "simulated_depth.yaml")
    room = replace(room, cameras=dict(list(room.cameras.items())[:cameras]))
    room_file.save(room, tmp_path / "room.yaml")
    with fs.run(ROOMS.parent / "depth.yaml", room=tmp_path / "room.yaml", frames=90, out=tmp_path) as run:
        scores = {row["target"]: row for row in run.wait().accuracy}
    assert set(scores) == {"green", "red", "blue"}
    for name, row in scores.items():
        assert row["coverage"] > coverage, name
        assert row["rmse_mm"] < 15, name
        assert row["identity_switches"] == 0, name


def test_one_colour_and_one_depth_camera_track_all_balls_by_name(tmp_path: Path) -> None:
    room = room_file.load(ROOMS / "simulated_mixed.yaml")
    room = replace(room, cameras={name: room.cameras[name] for name in ("cam0", "depth0")})
    targets = {n: replace(t, gray={}, area={"cam0": t.area["cam0"]}) for n, t in room.targets.items()}
    room_file.save(replace(room, targets=targets), tmp_path / "room.yaml")
    with fs.run(ROOMS.parent / "mixed.yaml", room=tmp_path / "room.yaml", frames=60, out=tmp_path) as run:
        scores = {row["target"]: row for row in run.wait().accuracy}
    for name, row in scores.items():
        assert row["coverage"] > 0.5, name  # it hides from one of the two for a while
        assert row["rmse_mm"] < 15, name
        assert row["identity_switches"] == 0, name

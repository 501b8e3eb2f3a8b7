"""What the simulated cameras show."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from followspot import Context, InputError, Room, room_file
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.messages import Header
from followspot_sim.camera import SimCamera
from followspot_sim.parameters import SimParams
from followspot_sim.rendering.picture import Picture
from followspot_sim.truth import SimTruth
from followspot_sim.visibility import visible_fraction

ROOM_FILE = Path(__file__).parents[3] / "graphs/rooms/simulated.yaml"
ROOM = room_file.load(ROOM_FILE)
EVERY = pytest.mark.parametrize("name", ROOM.cameras)
INFRARED = [name for name, camera in ROOM.cameras.items() if camera.kind == "infrared"]


def shot(name: str, frame: int, **params: object) -> np.ndarray:
    picture = Picture(SimParams(**params), ROOM, ROOM.cameras[name])
    pixels = np.empty(picture.shape, np.uint8)
    picture.render(frame, pixels)
    return pixels


def fingerprint(name: str) -> str:
    digest = hashlib.sha256()
    for frame in (0, 90, 400):
        digest.update(shot(name, frame, seed=7).tobytes())
    return digest.hexdigest()


def test_the_same_seed_gives_the_same_pixels_in_another_process():
    program = (
        "import sys, hashlib, numpy as np\n"
        "from followspot import room_file\n"
        "from followspot_sim.parameters import SimParams\n"
        "from followspot_sim.rendering.picture import Picture\n"
        "room = room_file.load(sys.argv[1])\n"
        "for name in ('cam4', 'cam0'):\n"  # in another order, and from the last frame to the first
        "    picture = Picture(SimParams(seed=7), room, room.cameras[name])\n"
        "    shots = []\n"
        "    for frame in (400, 90, 0):\n"
        "        pixels = np.empty(picture.shape, np.uint8)\n"
        "        picture.render(frame, pixels)\n"
        "        shots.append(pixels.tobytes())\n"
        "    print(hashlib.sha256(b''.join(reversed(shots))).hexdigest())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(ROOM_FILE)], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [fingerprint("cam4"), fingerprint("cam0")]


@EVERY
def test_another_seed_gives_another_picture(name):
    assert not np.array_equal(shot(name, 30, seed=1), shot(name, 30, seed=2))


@EVERY
def test_the_centroid_of_a_free_ball_is_its_projected_centre(name):
    camera = ROOM.cameras[name]
    picture = Picture(SimParams(only_target="green", noise_sigma=0), ROOM, camera)
    pixels, errors = np.empty(picture.shape, np.uint8), []
    for frame in range(40):
        picture.render(frame, pixels)
        centre = project(camera, picture.world.scene(frame).balls[:1])[0]
        (u, v), brightness = np.round(centre).astype(int), pixels.max(axis=2).astype(float)
        window = brightness[v - 9 : v + 10, u - 9 : u + 10]
        if window.shape == (19, 19):
            weight = np.where(window > 90, window - 60, 0)
            y, x = np.mgrid[v - 9 : v + 10, u - 9 : u + 10]
            errors.append(np.hypot((weight * x).sum() / weight.sum() - centre[0],
                                   (weight * y).sum() / weight.sum() - centre[1]))  # fmt: skip
    assert len(errors) > 25
    assert np.median(errors) < 0.05
    assert np.quantile(errors, 0.9) < 0.1  # a hot pixel within the window may pull the rest


@pytest.mark.parametrize("name", INFRARED)
def test_projections_never_appear_in_infrared(name):
    for frame in (0, 200):
        lit = shot(name, frame, projections=12, projection_brightness=1.0)
        assert np.array_equal(lit, shot(name, frame, projections=0))


def test_projections_appear_in_colour_cameras():
    lit, dark = (shot("cam0", 60, projections=n).astype(int) for n in (6, 0))
    assert ((lit - dark).max(axis=2) > 60).sum() > 100


def test_projections_reach_the_brightness_of_the_balls_where_that_is_wanted():
    glow = shot("cam0", 60, projections=6, projection_brightness=1.0, people=0, colors={"green": (9, 9, 9)})
    assert ((glow[..., 2] > 200) & (glow[..., 1] < 120)).sum() > 50  # red spots, larger than the red ball


def hidden_moments() -> list[tuple[int, int]]:
    """(frame, target) of balls that no camera sees, in the middle of their absence."""
    truth = SimTruth(Context("truth", ROOM), seed=7)
    truth.setup()
    hidden = np.array([truth.truth(frame).hidden for frame in range(0, 900, 30)])
    return [(30 * int(k), int(target)) for k, target in np.argwhere(hidden)]


def test_a_hidden_ball_is_invisible_in_every_camera():
    moments = hidden_moments()
    assert len(moments) > 3
    for frame, target in moments[:: len(moments) // 2]:
        name = list(ROOM.targets)[target]
        for camera in ROOM.cameras:
            pictures = [
                shot(camera, frame, seed=7, projections=0, noise_sigma=0, colors={name: color})
                for color in ((255, 255, 255), (10, 10, 10))
            ]
            assert np.array_equal(*pictures)
            if camera in INFRARED:
                u, v = np.round(project(ROOM.cameras[camera], ball_at(frame)[target][None])[0]).astype(int)
                around = pictures[0][max(v - 3, 0) : v + 4, max(u - 3, 0) : u + 4]
                assert np.median(around) < 60


def ball_at(frame: int) -> np.ndarray:
    return Picture(SimParams(seed=7), ROOM, ROOM.cameras["cam0"]).world.scene(frame).balls


def test_what_the_truth_calls_visible_is_what_the_picture_shows():
    picture = {
        color: Picture(
            SimParams(seed=7, projections=0, noise_sigma=0, colors={"red": color}), ROOM, ROOM.cameras["cam2"]
        )
        for color in ((255, 255, 255), (10, 10, 10))
    }
    truth = SimTruth(Context("truth", ROOM), seed=7)
    truth.setup()
    checked = 0
    for frame in range(0, 900, 15):
        scene = truth._world.scene(frame)
        share = visible_fraction([ROOM.cameras["cam2"]], scene, truth._radii)[0, 1]
        shots = []
        for camera in picture.values():
            pixels = np.empty(camera.shape, np.uint8)
            camera.render(frame, pixels)
            shots.append(pixels.astype(int).max(axis=2))
        core = (np.abs(shots[0] - shots[1]) > 150).sum()
        distance = np.linalg.norm(scene.balls[1] - ROOM.cameras["cam2"].center)
        whole = np.pi * (ROOM.cameras["cam2"].matrix[0, 0] * 0.0762 / distance) ** 2
        assert abs(min(core / whole, 1.0) - share) < 0.35
        checked += share < 0.8
    assert checked > 3


def test_noise_has_the_wanted_spread():
    quiet, loud = (shot("cam1", 0, noise_sigma=n).astype(float) for n in (0, 4.0))
    lit = quiet > 8  # where black does not clip
    assert np.std((loud - quiet)[lit]) == pytest.approx(4.0, rel=0.1)


def test_a_stage_yields_stamped_frames_and_then_ends():
    stage = SimCamera(Context.serving(ROOM.cameras["cam1"], ROOM, name="camera/cam1"), frames=3, fps=50)
    stage.setup()
    frames = [seal(frame) for frame in stage.process()]
    assert [frame.header for frame in frames] == [Header("", k, k * 20_000_000) for k in range(3)]
    assert frames[0].camera == "cam1"
    assert frames[0].pixels.shape == (240, 320, 1)
    assert not np.array_equal(frames[0].pixels, frames[2].pixels)


def test_zero_frames_never_end():
    stage = SimCamera(
        Context.serving(ROOM.cameras["cam1"], ROOM, name="camera/cam1"), frames=0, projections=0, people=0
    )
    stage.setup()
    source = stage.process()
    assert [next(source).header.seq for _ in range(5)] == list(range(5))


def test_the_number_of_messages_is_known_unless_they_never_end():
    context = Context.serving(ROOM.cameras["cam1"], ROOM, name="camera/cam1")
    assert SimCamera(context, frames=30).length() == SimTruth(context, frames=30).length() == 30
    assert SimCamera(context, frames=0).length() is SimTruth(context, frames=0).length() is None


def test_a_picture_does_not_depend_on_who_else_looks():
    company = {k: Picture(SimParams(), ROOM, camera) for k, camera in ROOM.cameras.items()}
    for name, camera in ROOM.cameras.items():
        single = Picture(SimParams(), Room(ROOM.name, {name: camera}, ROOM.planes, ROOM.targets), camera)
        pixels, expected = np.empty(single.shape, np.uint8), np.empty(single.shape, np.uint8)
        for frame in (350, 20):
            company[name].render(frame, pixels)
            single.render(frame, expected)
            assert np.array_equal(pixels, expected), name


def test_truth_tells_of_all_targets_in_the_order_of_the_room():
    stage = SimTruth(Context("truth", ROOM), frames=2)
    stage.setup()
    messages = [seal(message) for message in stage.process()]
    assert messages[0].objects == tuple(ROOM.targets)
    assert messages[1].header.time == round(1e9 / 60)
    assert messages[0].trackable.all()


def test_an_unknown_target_alone_is_refused_with_the_names_there_are():
    stage = SimTruth(Context("truth", ROOM), only_target="gren")
    with pytest.raises(InputError, match='did you mean "green"'):
        stage.setup()


@pytest.mark.parametrize("named", [{"only_target": "gren"}, {"colors": {"gren": [1, 2, 3]}}])
def test_the_check_names_targets_that_the_room_has_not(named: dict[str, object]):
    (key,) = named
    with pytest.raises(InputError, match=rf'(?s)^{key}: the room has no target "gren".*did you mean "green"'):
        SimCamera.check_files(SimCamera.Params(**named), ROOM, None)
    with pytest.raises(InputError, match=key):
        Picture(SimParams(**named), ROOM, ROOM.cameras["cam0"])


def test_a_picture_without_any_ball_in_it_is_rendered_too():
    away = replace(ROOM.cameras["cam1"], translation=np.array([0.0, 0.0, -50.0]))
    picture = Picture(SimParams(people=0), ROOM, away)
    pixels = np.empty(picture.shape, np.uint8)
    picture.render(0, pixels)
    assert np.median(pixels) < 20


def test_a_camera_whose_clock_is_off_by_a_frame_takes_the_neighbouring_picture():
    camera = ROOM.cameras["cam1"]
    on_time = Picture(SimParams(seed=7, noise_sigma=0, fps=50), ROOM, camera)
    late = Picture(SimParams(seed=7, noise_sigma=0, fps=50), ROOM, camera, clock_offset=1 / 50)
    expected, found = np.empty(on_time.shape, np.uint8), np.empty(on_time.shape, np.uint8)
    on_time.render(41, expected)
    late.render(40, found)
    assert np.array_equal(found, expected)


def test_no_camera_looks_before_the_performance_begins():
    picture = Picture(SimParams(), ROOM, ROOM.cameras["cam0"], clock_offset=-0.01)
    assert picture.world.scene(0).time == 0.0


@pytest.mark.parametrize("name", ["cam0", INFRARED[0]])
def test_a_camera_that_sees_no_ball_shows_the_room(name: str) -> None:
    camera = ROOM.cameras[name]
    away = replace(camera, matrix=camera.matrix + np.array([[0, 0, 1e5], [0, 0, 0], [0, 0, 0]]))
    room = replace(ROOM, cameras={**ROOM.cameras, name: away})
    picture = Picture(SimParams(), room, away)
    pixels = np.empty(picture.shape, np.uint8)
    picture.render(0, pixels)
    assert pixels.any()

"""What the simulated cameras show of people, and what the truth says of them."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot import Camera, Context, Room, room_file
from followspot.cli.main import main
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.messages import Header
from followspot.room import Member
from followspot_accuracy import read_pose_truth_csv
from followspot_sim.actor.body import SKULL
from followspot_sim.actor.camera import PersonCamera
from followspot_sim.actor.cast import cast_of
from followspot_sim.actor.paint import in_picture, patches
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.picture import ActorPicture
from followspot_sim.actor.points import PersonPoints
from followspot_sim.actor.pose import Stance, posed
from followspot_sim.actor.truth import PoseTruthOfActors
from followspot_sim.actor.visibility import VisibilityOfActors

ROOMS = Path(__file__).parents[3] / "graphs/rooms"
AHEAD = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Rotation of a level camera that looks along x."""
QUIET = ActorParams(
    seed=3, people=1, noise_sigma=0, room_size=(8.0, 8.0, 2.7), walking_area=(1.0, -1.2, 3.0, 1.2)
)


def pinhole(width: int = 320, height: int = 240, x: float = -2.0) -> Camera:
    matrix = np.array([[0.7 * width, 0, (width - 1) / 2], [0, 0.7 * width, (height - 1) / 2], [0, 0, 1]])
    return Camera("cam", "color", (width, height), matrix, np.zeros(5), AHEAD, -AHEAD @ [x, 0, 1.2])


def panorama(width: int = 698, height: int = 200) -> Camera:
    focal = width / (2 * np.pi)
    matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    return Camera(
        "pan", "color", (width, height), matrix, np.zeros(5), AHEAD, -AHEAD @ [0, 0, 1.2], "cylinder"
    )


CAMERAS = pytest.mark.parametrize("camera", [pinhole(), panorama()], ids=["pinhole", "panorama"])


def shot(picture: ActorPicture, frame: int) -> np.ndarray:
    pixels = np.empty(picture.shape, np.uint8)
    picture.render(frame, pixels)
    return pixels


def changed(params: ActorParams, camera: Camera) -> Callable[[int], np.ndarray]:
    """Of each frame the pixels in which people are, though not their shadows."""
    empty = shot(ActorPicture(params.model_copy(update={"people": 0}), camera), 0)
    full = ActorPicture(params, camera)
    return lambda frame: np.abs(shot(full, frame).astype(int) - empty).max(axis=2) > 24


def truth_of(params: ActorParams, *cameras: Camera) -> PoseTruthOfActors:
    room = Room("sim", {c.name: c for c in cameras})
    stage = PoseTruthOfActors(Context("truth", room), **params.model_dump())
    stage.setup()
    return stage


@CAMERAS
def test_the_head_is_where_the_truth_says(camera):
    truth, people = truth_of(QUIET, camera), changed(QUIET, camera)
    for frame in (0, 40, 90):
        now = truth.truth(frame)
        top = project(camera, np.column_stack([now.xy, now.height]))[0]
        rows, columns = np.nonzero(people(frame))
        head = columns[rows < rows.min() + 5]
        pixel = camera.matrix[1, 1] / np.hypot(*(now.xy[0] - camera.center[:2]))  # of a metre
        assert rows.min() == pytest.approx(top[1], abs=1.5)
        assert np.median(head) == pytest.approx(top[0], abs=2 + 0.12 * pixel)  # it juts forward of the place


def test_the_place_of_a_person_is_in_the_middle_of_the_body():
    camera = panorama()
    now = truth_of(QUIET, camera).truth(60)
    rows, columns = np.nonzero(changed(QUIET, camera)(60))
    centre = project(camera, np.column_stack([now.xy, now.height * 0.7]))[0]
    chest = columns[np.abs(rows - centre[1]) < 4]
    assert (chest.min() + chest.max()) / 2 == pytest.approx(centre[0], abs=6)


def test_someone_who_faces_the_camera_shows_a_face_and_someone_who_turns_away_does_not():
    actor = cast_of(3, 1)[0]
    face = (actor.body.region == SKULL) & (actor.body.mesh.centre()[:, 0] > 0.1)
    shares = []
    for heading in (np.pi, 0.0):
        surface = posed(actor.body, Stance(2.0, 0.0, heading, 0.0, 0.0, 0.0, 0.0))
        seen = patches(pinhole(), surface, actor.body.mesh.face)
        shares.append(face[seen.face].sum())
    assert shares[0] > 50
    assert shares[1] < shares[0] / 10  # the lower side of the nose


@pytest.mark.parametrize(("pan", "tilt"), [(0.6, 0.0), (0.0, 0.3), (-0.4, -0.2)])
def test_pan_turns_the_head_to_the_left_and_tilt_lifts_the_face(pan, tilt):
    body = cast_of(1, 1)[0].body
    straight, turned = (
        posed(body, Stance(0.0, 0.0, 0.0, p, t, 0.0, 0.0)) for p, t in ((0.0, 0.0), (pan, tilt))
    )
    nose = int(np.argmax(straight[:, 0] * (body.mesh.vertex[:, 2] > 1.58)))
    move = turned[nose] - straight[nose]
    assert np.sign(round(move[1], 3)) == np.sign(pan)
    assert np.sign(round(move[2], 3)) == np.sign(tilt)


@pytest.mark.parametrize("seed", [1, 2, 5])
def test_people_stand_on_the_floor_and_are_as_tall_as_people(seed):
    for actor in cast_of(seed, 3):
        for phase in (0.0, 1.0, 2.5, 4.0):
            surface = posed(actor.body, Stance(0.3, -0.2, 1.0, 0.2, 0.1, 1.0, phase))
            assert surface[:, 2].min() == pytest.approx(0.0, abs=1e-9)
            assert 1.5 < surface[actor.body.top, 2].max() < 2.0


def test_people_walk_without_jumps_turn_at_a_human_rate_and_keep_apart():
    truth = truth_of(ActorParams(seed=4, people=3, fps=20, walking_area=(-2, -2, 2, 2)))
    poses = [truth.truth(frame) for frame in range(600)]
    xy = np.array([pose.xy for pose in poses])
    speed = np.linalg.norm(np.diff(xy, axis=0), axis=2) * 20
    assert speed.max() < 2.0
    assert (speed.max(axis=0) > 0.5).all()
    turn = np.diff(np.unwrap([pose.heading for pose in poses], axis=0), axis=0) * 20
    assert 1.0 < np.abs(turn).max() < 4.0
    i, j = np.triu_indices(3, 1)
    assert np.linalg.norm(xy[:, i] - xy[:, j], axis=2).min() > 0.35
    assert np.abs(np.array([pose.pan for pose in poses])).max() < 0.8


def test_someone_behind_the_cupboard_is_hidden_in_the_picture_and_in_the_truth():
    params = QUIET.model_copy(
        update={"area": (-2.6, -2.6, 1.7, 2.6), "clear": 1.1, "cupboard": (2.4, 0.4), "fps": 2.0}
    )
    camera = panorama()
    truth = truth_of(params, camera)
    share = np.array([truth.truth(frame).visible[0] for frame in range(160)])
    assert (share > 0.95).mean() > 0.5
    hidden = np.flatnonzero(share < 0.05)
    assert len(hidden) > 1
    shown = int(np.flatnonzero(share > 0.99)[0])
    people = changed(params, camera)
    assert people(shown).sum() > 10 * people(int(hidden[0])).sum()


def test_nobody_is_hidden_by_the_edge_of_a_picture_that_shows_all():
    visible = [VisibilityOfActors(QUIET, camera).visible for camera in (pinhole(), pinhole(x=20.0))]
    play = ActorPicture(QUIET, pinhole(64, 48))._stage.play(10)
    assert visible[0](play)[0] > 0.95
    assert visible[1](play)[0] == 0.0


def test_the_nearer_of_two_people_hides_the_other():
    params = QUIET.model_copy(update={"people": 2, "size": (9.0, 9.0, 2.7)})
    truth = truth_of(params, pinhole())
    covered = 0
    for frame in range(0, 900, 10):
        now = truth.truth(frame)
        offset = now.xy - pinhole().center[:2]
        bearing, away = np.arctan2(offset[:, 1], offset[:, 0]), np.hypot(*offset.T)
        if abs(bearing[0] - bearing[1]) < 0.04:
            covered += 1
            assert now.visible[away.argmax()] < 0.6
            assert now.visible[away.argmin()] > 0.9
    assert covered > 0


def test_someone_on_the_seam_of_a_panorama_is_drawn_at_both_ends():
    camera = panorama()
    body = cast_of(1, 1)[0].body
    surface = posed(body, Stance(-2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    windows = [p.window for p in in_picture(camera, patches(camera, surface, body.mesh.face))]
    assert len(windows) == 2
    assert min(w[0] for w in windows) < 0 < max(w[2] for w in windows) - camera.size[0]


def test_the_same_seed_gives_the_same_pixels_in_another_process_and_order():
    program = (
        "import sys, hashlib, numpy as np\n"
        "from followspot import room_file\n"
        "from followspot_sim.actor.parameters import ActorParams\n"
        "from followspot_sim.actor.picture import ActorPicture\n"
        "room = room_file.load(sys.argv[1])\n"
        "picture = ActorPicture(ActorParams(**room.cameras['left'].source.params), room.cameras['left'])\n"
        "pixels = np.empty(picture.shape, np.uint8)\n"
        "for frame in (200, 7):\n"
        "    picture.render(frame, pixels)\n"
        "print(hashlib.sha256(pixels.tobytes()).hexdigest())\n"
    )
    path = ROOMS / "simulated_persons.yaml"
    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=True
    )

    left = room_file.load(path).cameras["left"]
    assert left.source is not None
    here = shot(ActorPicture(ActorParams(**left.source.params), left), 7)
    assert hashlib.sha256(here.tobytes()).hexdigest() == done.stdout.strip()


def test_another_seed_is_another_performance():
    a, b = (truth_of(QUIET.model_copy(update={"seed": seed})).truth(30) for seed in (1, 2))
    assert np.hypot(*(a.xy - b.xy)[0]) > 0.05


def test_stages_yield_stamped_messages_and_then_end():
    camera = pinhole(64, 48)
    room = Room("sim", {"cam": camera})
    for stage in (
        PersonCamera(Context.serving(camera, room, name="camera/cam"), frames=3, fps=10),
        PoseTruthOfActors(Context("truth", room), frames=3, fps=10),
    ):
        stage.setup()
        assert stage.length() == 3
        messages = [seal(message) for message in stage.process()]
        assert [m.header for m in messages] == [Header("", k, k * 100_000_000) for k in range(3)]


@pytest.mark.parametrize("name", ["simulated_panorama", "simulated_persons"])
def test_cameras_and_truth_of_a_ready_room_play_the_same(name):
    room = room_file.load(ROOMS / f"{name}.yaml")
    assert room.truth is not None
    assert room.truth.uses == "sim.pose_truth"
    for camera in room.cameras.values():
        assert camera.source is not None
        assert camera.source.params == room.truth.params


@pytest.mark.thorough
def test_in_the_ready_panorama_people_leave_and_return():
    room = room_file.load(ROOMS / "simulated_panorama.yaml")
    assert room.truth is not None
    stage = PoseTruthOfActors(Context("truth", room), **room.truth.params)
    stage.setup()
    visible = np.array([stage.truth(frame).visible for frame in range(0, 400, 2)])
    assert (visible.min(axis=0) < 0.1).any()
    assert ((visible > 0.5).mean(axis=0) > 0.7).all()
    assert (visible[-1] > 0.5).any()


@pytest.mark.thorough
def test_a_recording_of_people_holds_the_pictures_and_the_poses_that_the_stages_give(tmp_path):
    path = ROOMS / "simulated_persons.yaml"
    command = ["simulate", "--room", str(path), "--out", str(tmp_path), "--frames", "2", "--seed", "5"]
    assert main(command) == 0
    room = room_file.load(path)
    camera = room.cameras["front"]
    assert camera.source is not None
    params = ActorParams(**{**camera.source.params, "seed": 5, "frames": 2})
    video = cv2.VideoCapture(str(tmp_path / "front.mkv"))
    assert np.array_equal(video.read()[1], shot(ActorPicture(params, camera), 0))
    table = read_pose_truth_csv(*(tmp_path / f"{name}_gt.csv" for name in room.cameras))
    now = truth_of(params, *room.cameras.values()).truth(1)
    wanted = np.column_stack([now.xy, now.height, now.heading, now.pan, now.tilt])
    assert np.allclose(table.pose[1], wanted, atol=1e-4)
    assert np.allclose(table.visible[1], now.visible, atol=1e-4)


def test_dimmed_lights_leave_their_share_for_their_time() -> None:
    dim = QUIET.model_copy(update={"dimmed": (1.0, 2.0, 0.25)})
    usual, dimmed = (ActorPicture(params, pinhole()) for params in (QUIET, dim))
    for second, share in ((0.5, 1.0), (1.5, 0.25), (2.0, 1.0)):
        frame = round(second * QUIET.fps)
        mean = shot(dimmed, frame).mean() / shot(usual, frame).mean()
        assert mean == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize("wrong", [(2.0, 1.0, 0.5), (0.0, 1.0, 1.5)])
def test_dimmed_lights_need_ascending_times_and_a_share(wrong: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="dimmed must be"):
        ActorParams(dimmed=wrong)


@pytest.mark.parametrize("wrong", [(-1.0, 2.0, 3.0), (6.0, 0.0, 2.7)])
def test_a_room_has_a_width_a_depth_and_a_height(wrong: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="room_size must be"):
        ActorParams(room_size=wrong)


def test_a_network_finds_nobody_in_an_empty_room() -> None:
    room = Room("sim", {"cam": pinhole()})
    stage = PersonPoints(Context("points", room, Member("cameras", "cam")), people=0)
    stage.setup()
    first = next(iter(stage.process()))
    assert (len(first.points.pixel), first.boxes.box.shape) == (0, (0, 4))

"""`calibrate board`: where cameras stand, from a board that pairs of them see."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.drawn_boards import Photographer, Place, lens

from followspot.cli.main import main
from followspot.errors import FollowspotError, InputError
from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera, Room
from followspot.room_file import load, save
from followspot_calibrate.board.chain import chained
from followspot_calibrate.board.poses import BoardPose, Relation, board_poses, relate
from followspot_calibrate.board.rigidity import distances
from followspot_calibrate.board.solving import solve
from followspot_calibrate.board.text import warnings_of
from followspot_calibrate.board.timestamps import read_timestamps
from followspot_calibrate.boards.board import parse_board
from followspot_calibrate.boards.detection import View
from followspot_calibrate.similarity import Similarity

CALISCOPE = dataset("calib-charuco-4cam-caliscope")
BOARD = parse_board("charuco:6x5:0.06:DICT_4X4_50")


def standing(name: str, at: tuple[float, float, float], toward: tuple[float, float, float]) -> Camera:
    """A camera upright in the room."""
    z = np.subtract(toward, at) / np.linalg.norm(np.subtract(toward, at))
    x = np.cross(z, [0.0, 0.0, 1.0])
    R = np.array([x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x)), z])
    return lens(name=name, rotation=R, translation=-R @ np.array(at))


def circle(count: int, radius: float = 2.5) -> list[Camera]:
    """Cameras that look at the middle of the room from all sides."""
    angles = np.arange(count) * 2 * np.pi / count
    return [
        standing(f"cam{i}", (radius * np.cos(a), radius * np.sin(a), 1.8), (0, 0, 1))
        for i, a in enumerate(angles)
    ]


def row(count: int) -> list[Camera]:
    """Cameras along a wall; only neighbours look at the same part of the room."""
    return [standing(f"cam{i}", (1.6 * i, -2.0, 1.5), (1.6 * i, 0.0, 1.0)) for i in range(count)]


def carried(cameras: list[Camera], moments: int, spread: tuple[float, float, float], noise: float = 0.0):
    """Views of a board that wanders through the room with its face to one camera after the other."""
    rng = np.random.default_rng(5)
    views: dict[str, list[View]] = {camera.name: [] for camera in cameras}
    flat = BOARD.corners - BOARD.corners.mean(axis=0)
    for moment in range(moments):
        at = rng.uniform(-0.5, 0.5, 3) * spread + [np.mean([c.center[0] for c in cameras]), 0.0, 1.0]
        facing = cameras[moment % len(cameras)]
        R = facing.rotation.T @ cv2.Rodrigues(rng.uniform(-0.5, 0.5, 3))[0]
        corners = flat @ R.T + at
        for camera in cameras:
            pixel = project(camera, corners) + rng.normal(0, noise, (len(corners), 2))
            front = (camera.center - at) @ R[:, 2] < -0.3  # the pattern is on one side only
            inside = ((pixel >= 0) & (pixel < camera.size)).all(axis=1)
            if front and inside.sum() >= 6:
                views[camera.name].append(View(moment, np.flatnonzero(inside), pixel[inside], 1.5))
    return views


def unknown(cameras: list[Camera]) -> list[Camera]:
    """The same lenses; only the first camera's pose is known."""
    return [cameras[0], *(replace(c, rotation=np.eye(3), translation=np.zeros(3)) for c in cameras[1:])]


def apart(found: tuple[Camera, ...], true: list[Camera]) -> Array:
    """Distances of the centres, m."""
    pairs = zip(found, true, strict=True)
    return np.array([np.linalg.norm(a.center - b.center) for a, b in pairs])


def test_poses_are_exact_for_exact_views() -> None:
    true = circle(4)
    found = solve(unknown(true), carried(true, 60, (1.5, 1.5, 0.6)), BOARD)
    assert apart(found.cameras, true).max() < 1e-6
    assert found.distances.rmse_mm < 1e-4
    assert found.rejected.sum() == 0
    assert found.scale == pytest.approx(1.0, abs=1e-6)
    assert warnings_of(found) == []


def test_cameras_in_a_row_are_chained_though_no_place_is_seen_by_all() -> None:
    """Noise of 0.2 px; 8 m from end to end, so the bar is 1 cm at the far end."""
    true = row(5)
    views = carried(true, 150, (8.0, 0.8, 0.6), noise=0.2)
    frames = [{view.frame for view in of_camera} for of_camera in views.values()]
    assert not set.intersection(*frames)
    found = solve(unknown(true), views, BOARD)
    assert apart(found.cameras, true).max() < 0.01
    assert found.rms.max() < 0.35


def test_wrong_corners_are_rejected() -> None:
    true = circle(4)
    views = carried(true, 80, (1.5, 1.5, 0.6), noise=0.2)
    for view in views["cam2"][::4]:
        view.pixel[::3] += [15.0, -9.0]
    found = solve(unknown(true), views, BOARD)
    assert found.rejected[2] > 0
    assert apart(found.cameras, true).max() < 0.01


def test_camera_without_a_shared_view_is_named_with_the_remedy() -> None:
    true = circle(4)
    views = carried(true, 60, (1.5, 1.5, 0.6))
    views["cam3"] = [replace(view, frame=view.frame + 1000) for view in views["cam3"]]
    with pytest.raises(FollowspotError, match=r"cam3 agree on 0 moments.*3 needed: show the board to cam3"):
        solve(unknown(true), views, BOARD)


def test_board_on_the_floor_makes_the_room() -> None:
    true = circle(4)
    views = carried(true, 60, (1.5, 1.5, 0.6))
    lying = Place((np.pi, 0.0, 0.0), (0.4, 0.3, 0.0))  # face up, in the room's coordinates
    R = cv2.Rodrigues(np.array(lying.tilt))[0]
    corners = BOARD.corners @ R.T + np.array(lying.middle)
    for camera in true:
        views[camera.name].append(View(500, np.arange(len(corners)), project(camera, corners), 1.5))
    found = solve(unknown(true), views, BOARD, floor=500)
    expected = np.array([camera.center for camera in true]) - lying.middle
    np.testing.assert_allclose([camera.center for camera in found.cameras], expected, atol=1e-6)


def test_moment_without_a_board_on_the_floor_is_answered_with_the_nearest() -> None:
    true = circle(4)
    with pytest.raises(FollowspotError, match=r"--floor 4000: two cameras do not see .* nearest moment is"):
        solve(unknown(true), carried(true, 60, (1.5, 1.5, 0.6)), BOARD, floor=4000)


def test_cameras_out_of_step_are_told() -> None:
    """A board that moves 5 to 10 cm from picture to picture, to and fro; one camera is a picture late."""
    true = circle(3)
    views: dict[str, list[View]] = {camera.name: [] for camera in true}
    for moment in range(60):
        for camera in true:
            late = moment - (camera.name == "cam2")
            tilt = cv2.Rodrigues(np.array([0.3, 0.2, 0.02 * late]))[0]
            R = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ tilt
            at = [0.5 * np.sin(0.11 * late), 0.5 * np.sin(0.17 * late), 1.0 + 0.2 * np.sin(0.07 * late)]
            corners = BOARD.corners @ R.T + at
            views[camera.name].append(View(moment, np.arange(len(corners)), project(camera, corners), 1.5))
    with pytest.raises(
        FollowspotError, match=r"of the corners in cam2 contradict .* in step with the others"
    ):
        solve(unknown(true), views, BOARD)


@pytest.mark.parametrize(
    "changed",
    [
        {"matrix": lens().matrix * [[1.1], [1.1], [1.0]]},
        pytest.param({"matrix": lens().matrix * [[2.0], [2.0], [1.0]]}, marks=pytest.mark.thorough),
        pytest.param({"distortion": np.zeros(5)}, marks=pytest.mark.thorough),
    ],
)
def test_exchanged_recordings_are_refused(changed: dict[str, Array]) -> None:
    true = circle(4)
    true[2] = replace(true[2], **changed)
    views = carried(true, 60, (1.5, 1.5, 0.6), noise=0.2)
    assert solve(unknown(true), views, BOARD)
    views["cam1"], views["cam2"] = views["cam2"], views["cam1"]
    with pytest.raises(FollowspotError, match="recordings of cam1 and cam2 are exchanged: each shows"):
        solve(unknown(true), views, BOARD)


def test_a_single_marker_places_cameras() -> None:
    true, marker = circle(3), parse_board("aruco:0.3:DICT_4X4_50:7")
    random, views = np.random.default_rng(3), {camera.name: [] for camera in true}
    for moment in range(40):
        R = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ cv2.Rodrigues(random.uniform(-0.5, 0.5, 3))[0]
        corners = marker.corners @ R.T + random.uniform([-0.6, -0.6, 0.6], [0.6, 0.6, 1.3])
        for camera in true:
            pixel = project(camera, corners) + random.normal(0, 0.1, (4, 2))
            views[camera.name].append(View(moment, np.arange(4), pixel, 1.5))
    found = solve(unknown(true), views, marker)
    assert apart(found.cameras, true).max() < 0.02
    assert found.distances.rmse_mm < 2


def test_flat_board_far_away_has_two_poses_and_the_right_ones_agree() -> None:
    a, b = circle(6)[:2]
    rng = np.random.default_rng(2)
    seen: list[list[list]] = [[], []]
    for _ in range(30):
        R = a.rotation.T @ cv2.Rodrigues(rng.uniform(-0.25, 0.25, 3))[0]
        corners = 0.3 * (BOARD.corners - BOARD.corners.mean(axis=0)) @ R.T + [0.0, 0.0, 1.0]
        for camera, poses in zip((a, b), seen, strict=True):
            pixel = project(camera, corners) + rng.normal(0, 0.1, (len(corners), 2))
            small = replace(BOARD, square=0.3 * BOARD.square)
            poses.append(board_poses(camera, View(0, np.arange(len(pixel)), pixel, 1.5), small))
    assert any(len(poses) == 2 for poses in seen[0])
    relation = relate(*seen)
    assert relation is not None
    expected = b.rotation @ a.rotation.T
    assert np.degrees(np.linalg.norm(cv2.Rodrigues(relation.pose.rotation @ expected.T)[0])) < 3
    assert relation.moments <= relation.shared == 30


def test_moments_agree_up_to_three_degrees_and_a_twentieth_of_the_distance() -> None:
    def placed(degrees: float, shift: float) -> BoardPose:
        rotation = cv2.Rodrigues(np.radians([0.0, degrees, 0.0]))[0]
        return BoardPose(Similarity(rotation, rotation @ [0.0, 0.0, 2.0] + [shift, 0.0, 0.0]), 0.1)

    here = [[placed(0, 0)]] * 8
    there = [(0, 0), (0.1, 0.002), (-0.1, 0), (0, -0.002), (2, 0), (4, 0), (0, 0.08), (0, 0.12)]
    relation = relate(here, [[placed(*where)] for where in there])
    assert relation is not None
    assert (relation.moments, relation.shared) == (6, 8)
    assert np.linalg.norm(relation.pose.shift) < 0.001
    assert relate([[]], [[placed(0, 0)]]) is None


@pytest.mark.parametrize("moments", [2, 3])
def test_three_moments_link_two_cameras_and_two_do_not(moments: int) -> None:
    pose = Similarity(np.eye(3), np.array([1.0, 0.0, 0.0]))
    pairs = {(0, 1): Relation(pose, moments, 9), (0, 2): Relation(pose, 9, 9)}
    if moments == 3:
        poses = chained(["left", "middle", "right"], pairs)
        np.testing.assert_array_equal(poses[1].shift, pose.shift)
        return
    with pytest.raises(FollowspotError, match=r"left-middle agree on 2 moments .* 3 needed"):
        chained(["left", "middle", "right"], pairs)


def test_distances_are_taken_within_a_moment_only() -> None:
    frame, label = np.array([0, 0, 0, 1, 1]), np.array([0, 1, 2, 0, 1])
    points = np.array([[0.0, 0, 0], [0.061, 0, 0], [np.nan] * 3, [5.0, 0, 0], [5.0, 0.06, 0]])
    found = distances(frame, label, points, BOARD)
    np.testing.assert_allclose(found.printed, [0.06, 0.06])
    np.testing.assert_allclose(found.measured, [0.061, 0.06])
    assert found.rmse_mm == pytest.approx(np.sqrt(0.5))


TIMES = "sync_index,cam_id,frame_index,frame_time\n7,0,40,1.0\n7,1,41,1.0\n8,0,41,1.1\n9,1,42,1.2\n"


def test_timestamps_pair_pictures_by_their_order(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(TIMES)
    assert read_timestamps(tmp_path / "t.csv", ["cam_0", "cam_1"]) == {
        "cam_0": {0: 7, 1: 8},
        "cam_1": {0: 7, 1: 9},
    }


def test_timestamps_need_no_frame_numbers(tmp_path: Path) -> None:
    table = "sync_index,cam_id,frame_time\n8,0,1.1\n7,0,1.0\n7,1,1.0\n9,1,1.2\n"
    (tmp_path / "t.csv").write_text(table)
    assert read_timestamps(tmp_path / "t.csv", ["cam0", "cam1"]) == {
        "cam0": {0: 7, 1: 8},
        "cam1": {0: 7, 1: 9},
    }


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("sync_index", "sync", "missing columns: sync_index"),
        ("7,1,41", "7,1,x", r't.csv:3:\d+: "x" in column frame_index'),
        ("7,1,41,1.0\n", "7,1\n", r"t.csv:3:1: 2 columns, 4 needed"),
        ("8,0,41,1.1", "8,0,40,1.1", r"t.csv:4:1: frame_index does not rise from line 2"),
        (",1,4", ",2,4", r"no row of camera cam_1(.|\n)*cam_id"),
    ],
)
def test_mistake_in_timestamps_is_told(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    (tmp_path / "t.csv").write_text(TIMES.replace(old, new))
    with pytest.raises(InputError, match=complaint):
        read_timestamps(tmp_path / "t.csv", ["cam_0", "cam_1"])


PAIR = [
    standing("left", (-0.3, -1.0, 1.0), (0.0, 0, 1.0)),
    standing("right", (0.3, -1.0, 1.0), (0.0, 0, 1.0)),
]


@pytest.fixture(scope="module")
def boards(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures of a board in two cameras."""
    folder = tmp_path_factory.mktemp("boards")
    rng = np.random.default_rng(1)
    photographers = [Photographer(camera, BOARD) for camera in PAIR]
    for camera in PAIR:
        (folder / camera.name).mkdir()
    for moment in range(6):
        R = PAIR[0].rotation.T @ cv2.Rodrigues(rng.uniform(-0.3, 0.3, 3))[0]
        at = np.array([0, -0.1, 1.0]) + rng.uniform(-0.15, 0.15, 3)
        for camera, photographer in zip(PAIR, photographers, strict=True):
            tilt = cv2.Rodrigues(camera.rotation @ R)[0].ravel()
            place = Place(tuple(tilt), tuple(camera.rotation @ at + camera.translation))
            cv2.imwrite(f"{folder}/{camera.name}/{moment}.png", photographer.picture(place))
    return folder


@pytest.fixture
def room(tmp_path: Path, boards: Path) -> Path:
    """The pictures, and a room file that knows the lenses and where the first camera is."""
    (tmp_path / "boards").symlink_to(boards)
    save(Room("r", {camera.name: camera for camera in unknown(PAIR)}), tmp_path / "room.yaml")
    return tmp_path


def calibrate(folder: Path, *more: str, board: str = "charuco:6x5:0.06:DICT_4X4_50") -> int:
    arguments = ["--room", str(folder / "room.yaml"), "--videos", str(folder / "boards"), "--board", board]
    return main(["calibrate", "board", *arguments, *more])


def test_command_writes_the_poses(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert calibrate(room, "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    left, right = load(room / "room.yaml").cameras.values()
    np.testing.assert_allclose(left.center, [-0.3, -1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(right.center, [0.3, -1.0, 1.0], atol=0.005)
    assert answer["rigidity_rmse_mm"] < 1.0
    assert answer["pairs"][0]["shared"] == 6
    assert any("linked by 6 moments only" in note for note in answer["warnings"])
    page = (room / "room.board.html").read_text()
    assert "left – right" in page
    assert "linked by 6 moments only" in page


def test_the_page_goes_where_it_is_asked_to(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = room / "looked_at.html"
    assert calibrate(room, "--report", str(page)) == 0
    assert f"the page to look at: {page}" in capsys.readouterr().out
    assert "arrows ×" in page.read_text()
    assert not (room / "room.board.html").exists()


def test_camera_without_a_recording_keeps_its_pose(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cameras = {camera.name: camera for camera in [*unknown(PAIR), standing("top", (0, 0, 3.0), (0, 1, 0))]}
    save(Room("r", cameras), room / "room.yaml")
    assert calibrate(room) == 0
    np.testing.assert_array_equal(load(room / "room.yaml").cameras["top"].center, cameras["top"].center)
    assert "top has no recording and keeps its pose" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("board", "more", "complaint"),
    [
        ("chessboard:8x6:0.02", [], "ends of this chessboard cannot be told apart"),
        ("charuco:6x5:0.06:DICT_4X4_50", ["--clip", "top=room.yaml"], 'has no camera "top"'),
        ("charuco:6x5:0.06:DICT_4X4_50", ["--pictures", "0"], "--pictures 0 is less than 1"),
        ("charuco:6x5:0.06:DICT_4X4_50", ["--timestamps", "none.csv"], "none.csv cannot be read"),
    ],
)
def test_command_refuses_what_it_cannot_do(
    room: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    board: str,
    more: list[str],
    complaint: str,
) -> None:
    monkeypatch.chdir(room)
    assert calibrate(room, *more, board=board) == 2
    assert complaint in capsys.readouterr().err


def test_recording_of_another_size_is_refused(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cameras = load(room / "room.yaml").cameras
    save(Room("r", {name: replace(c, size=(320, 240)) for name, c in cameras.items()}), room / "room.yaml")
    assert calibrate(room) == 2
    assert "left is calibrated for 320x240 px, its recording is 640x480" in capsys.readouterr().err


@needs_data("calib-charuco-4cam-caliscope")
@pytest.mark.thorough
def test_real_board_is_rigid_to_two_millimetres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Four webcams, 54 mm squares; the poses agree with an earlier calibration by another program."""
    given = tmp_path / "room.yaml"
    assert main(["room", "import", str(CALISCOPE / "camera_array.toml"), "-o", str(given)]) == 0
    before = load(given).cameras
    blank = {n: replace(c, rotation=np.eye(3), translation=np.zeros(3)) for n, c in before.items()}
    save(Room("r", {**blank, "cam_0": before["cam_0"]}), given)
    capsys.readouterr()
    videos = ["--videos", str(CALISCOPE / "calibration/extrinsic"), "--pictures", "40", "--json"]
    board = ["--board", "charuco:4x5:0.054:DICT_4X4_1000:inverted"]
    assert main(["calibrate", "board", "--room", str(given), *videos, *board]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["rigidity_rmse_mm"] < 2.0
    assert answer["distances"] > 500
    after = load(given).cameras
    assert apart(tuple(after.values()), list(before.values())).max() < 0.03


def test_cameras_that_share_many_views_and_contradict_each_other_are_not_asked_for_more() -> None:
    pose = Similarity(np.eye(3), np.array([1.0, 0.0, 0.0]))
    with pytest.raises(FollowspotError, match=r"agree on 1 of the 40 moments .* out of step .* mirrored"):
        chained(["left", "right"], {(0, 1): Relation(pose, 1, 40)})

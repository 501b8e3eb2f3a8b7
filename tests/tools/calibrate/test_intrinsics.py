"""`calibrate intrinsics`: lenses from pictures of boards."""

import io
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.drawn_boards import Photographer, lens, places

from followspot import at
from followspot.cli.main import main
from followspot.errors import FollowspotError, InputError
from followspot.geometry import project
from followspot.messages import Array
from followspot.plugins.catalogue import catalogue
from followspot.port_marks import Source
from followspot.room import Camera, Room, StageUse
from followspot.room_file import load, save
from followspot.stage import Stage
from followspot.stage_params import Field, StageParams
from followspot.tracking import Frame
from followspot_calibrate.boards.board import parse_board
from followspot_calibrate.boards.detection import Detector, View
from followspot_calibrate.boards.pictures import live_pictures
from followspot_calibrate.intrinsics.calibration import calibrate_lens
from followspot_calibrate.intrinsics.collecting import collect
from followspot_calibrate.intrinsics.coverage import Coverage, coverage
from followspot_calibrate.intrinsics.fitting import NoFit, fit
from followspot_calibrate.intrinsics.selection import diverse, sharp

CHARUCO = "charuco:7x5:0.04:DICT_4X4_50"
BOARD = parse_board(CHARUCO)
SIZE = (640, 480)


def seen(
    camera: Camera,
    count: int = 14,
    noise: float = 0.1,
    tilt: float = 0.6,
    spread: tuple[float, float] = (0.35, 0.25),
) -> list[View]:
    """Views with the corners where the camera has them, and noise, px."""
    photographer, rng = Photographer(replace(camera, size=(2, 2)), BOARD), np.random.default_rng(3)
    views = []
    for number, place in enumerate(places(0.45, spread, count, tilt)):
        pixel = project(camera, photographer.corners(place)) + rng.normal(0, noise, (len(BOARD.corners), 2))
        inside = ((pixel >= 0) & (pixel < SIZE)).all(axis=1)
        views.append(View(number, np.flatnonzero(inside), pixel[inside], 1.5))
    return views


@pytest.mark.parametrize("model", ["pinhole", "fisheye"])
def test_lens_is_found_from_pictures(model: str) -> None:
    """Known lens, rendered ChArUco pictures: the focal length to 0.5 %, the whole projection to 0.3 px."""
    camera = lens(model)
    photographer = Photographer(camera, BOARD)
    near, spread = (0.4, (0.4, 0.3)) if model == "pinhole" else (0.22, (0.9, 0.6))
    pictures = enumerate(map(photographer.picture, places(near, spread)))
    collected = collect("cam0", iter(pictures), 12, Detector(BOARD), io.StringIO())
    found = calibrate_lens("cam0", collected.views, BOARD, collected.size, model)  # type: ignore[arg-type]
    assert found.fit.rms < 0.2
    assert found.fit.matrix[0, 0] == pytest.approx(camera.matrix[0, 0], rel=5e-3)
    read = replace(camera, matrix=found.fit.matrix, distortion=found.fit.distortion)
    corners = np.concatenate([photographer.corners(place) for place in places(near, spread)])
    inside = ((project(camera, corners) >= 0) & (project(camera, corners) < SIZE)).all(axis=1)
    # A camera that is turned a little sees the same with another principal point: compare up to that.
    away = project(read, corners[inside]) - project(camera, corners[inside])
    assert np.linalg.norm(away - away.mean(axis=0), axis=1).mean() < 0.3


@pytest.mark.parametrize("model", ["pinhole", "fisheye"])
def test_errors_are_as_large_as_the_sigmas_say(model: str) -> None:
    camera = lens(model)
    found = fit(seen(camera), BOARD, SIZE, model)  # type: ignore[arg-type]
    K = found.matrix
    away = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2]]) - camera.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    assert found.rms == pytest.approx(0.1 * np.sqrt(2), rel=0.15)
    assert (np.abs(away) < 4 * found.sigma[:4]).all()
    assert found.sigma[0] < 0.01 * K[0, 0]


def test_k3_that_is_noise_is_left_out_and_a_real_one_is_found() -> None:
    assert fit(seen(lens()), BOARD, SIZE, "pinhole").distortion[4] == 0.0
    strong = lens(distortion=np.array([-0.3, 0.1, 0.0, 0.0, 0.4]))
    assert fit(seen(strong, noise=0.02), BOARD, SIZE, "pinhole").distortion[4] == pytest.approx(0.4, abs=0.1)


def test_view_that_contradicts_the_others_is_rejected_by_name() -> None:
    views = seen(lens())
    wrong = views[5].pixel.copy()
    wrong[::3] += [6.0, -4.0]
    views[5] = replace(views[5], pixel=wrong)
    found = calibrate_lens("cam0", views, BOARD, SIZE, "pinhole")
    assert found.rejected == (5,)
    assert found.fit.rms < 0.2


@pytest.mark.parametrize("at", [0, 5, 14])
def test_views_that_are_no_board_do_not_cost_a_fisheye_lens_the_others(at: int) -> None:
    corners = np.arange(len(BOARD.corners))
    anywhere = np.random.default_rng(0).uniform([0, 0], SIZE, (len(corners), 2))
    views, nowhere = seen(lens("fisheye")), np.tile([300.0, 200.0], (len(corners), 1))
    for pixel in (anywhere, nowhere):
        wrong = View(99, corners, pixel, 1.5)
        found = fit([*views[:at], wrong, *views[at:]], BOARD, SIZE, "fisheye")
        assert [view.frame for view in found.views] == list(range(14))
    wrong = View(99, corners, anywhere, 1.5), View(100, corners, anywhere[::-1], 1.5)
    found = fit([*wrong, *views], BOARD, SIZE, "fisheye")
    assert not {99, 100} & {view.frame for view in found.views}
    assert found.rms < 0.2


def test_views_that_are_no_boards_give_no_fisheye_lens() -> None:
    corners = np.arange(len(BOARD.corners))
    pixels = np.random.default_rng(1).uniform([0, 0], SIZE, (4, len(corners), 2))
    with pytest.raises(FollowspotError, match="no fisheye lens explains the views"):
        fit([View(n, corners, pixel, 1.5) for n, pixel in enumerate(pixels)], BOARD, SIZE, "fisheye")
    with pytest.raises(FollowspotError, match="2 usable views of the board, at least 3"):
        fit(seen(lens("fisheye"))[:2], BOARD, SIZE, "fisheye")


def test_parallel_boards_are_told_to_leave_the_focal_length_open() -> None:
    found = calibrate_lens("cam0", seen(lens(), tilt=0.02), BOARD, SIZE, "pinhole")
    assert found.tilt < 20
    (told,) = [text for text in found.warnings if "parallel" in text]
    assert f"({found.fit.matrix[0, 0]:.0f} +- {found.fit.sigma[0]:.0f} px" in told
    assert "tilt the board" in told


def test_few_views_and_bare_parts_of_the_picture_are_told() -> None:
    views = [view for view in seen(lens(), count=20) if view.pixel[:, 0].mean() < 300][:6]
    found = calibrate_lens("cam0", views, BOARD, SIZE, "pinhole")
    assert any(text.startswith("only 6 views are usable") for text in found.warnings)
    assert any("covered" in text and "right" in text for text in found.warnings)


def test_good_views_give_no_warning() -> None:
    views = seen(lens(), count=30, spread=(0.55, 0.4))
    assert calibrate_lens("cam0", views, BOARD, SIZE, "pinhole").warnings == ()


def test_the_darker_a_cell_the_more_corners_it_has() -> None:
    count = np.zeros((6, 8), int)
    count[0] = [0, 1, 7, 8, 15, 16, 30, 900]
    edge, first, *others = Coverage(count).drawing()
    assert first == "|" + "".join(2 * shade for shade in " ..::*##") + "|"
    assert others == ["|" + 16 * " " + "|"] * 5 + [edge]


def test_coverage_names_what_is_missing() -> None:
    everywhere = np.stack(np.meshgrid(np.arange(5, 640, 20), np.arange(5, 480, 20)), axis=-1).reshape(-1, 2)
    left = everywhere[everywhere[:, 0] < 400].astype(float)
    covered = coverage([View(0, np.arange(len(left)), left, 1.0)], SIZE)
    assert covered.missing == ["upper right", "middle right", "lower right"]
    assert len({len(line) for line in covered.drawing()}) == 1
    assert coverage([], SIZE).share == 0.0


def test_blurred_views_are_left_out_unless_all_are_alike() -> None:
    views = [replace(view, blur=2.0) for view in seen(lens(), count=8)]
    views[3] = replace(views[3], blur=9.0)
    assert [view.frame for view in sharp(views)] == [0, 1, 2, 4, 5, 6, 7]
    assert len(sharp([replace(view, blur=9.0) for view in views])) == 8


def test_diverse_views_leave_out_repetitions() -> None:
    views = seen(lens(), count=10)
    repeated = [replace(view, frame=10 * view.frame + k) for view in views for k in range(5)]
    chosen = diverse(repeated, BOARD, SIZE, most=10)
    assert sorted(view.frame // 10 for view in chosen) == list(range(10))


class Films(Stage):
    """A live camera that shows a board."""

    live = True
    per_camera = True
    shown: list[Array] = []  # noqa: RUF012  # set by the test

    class Params(StageParams):
        device: int = Field(0, description="any", unit="1")

    def process(self) -> Source[Frame]:
        for number, picture in enumerate(self.shown):
            yield at(number, Frame(camera=self.camera.name, pixels=picture[:, :, None]))


def test_live_camera_is_its_source_and_still_views_count_once(monkeypatch: pytest.MonkeyPatch) -> None:
    photographer = Photographer(lens(), BOARD)
    Films.shown = [photographer.picture(place) for place in places(0.45, (0.3, 0.2), 3) for _ in range(4)]
    monkeypatch.setattr("followspot_calibrate.boards.pictures.load_stage", lambda name: Films)
    camera = lens(source=StageUse("cameras.device", {}))
    collected = collect("cam0", live_pictures(camera), None, Detector(BOARD), io.StringIO())
    assert (collected.looked_at, len(collected.views)) == (12, 3)


def test_device_becomes_the_source_of_a_new_camera(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    photographer = Photographer(lens(), BOARD)
    Films.shown = [photographer.picture(place) for place in places(0.42, (0.35, 0.25), 6)]
    monkeypatch.setattr("followspot_calibrate.boards.pictures.load_stage", lambda name: Films)
    assert intrinsics(tmp_path, "--device", "cam0=2", "--size", "640x480") == 0
    camera = load(tmp_path / "room.yaml").cameras["cam0"]
    assert camera.source is not None
    assert (camera.source.uses, camera.source.params) == ("cameras.device", {"device": 2})
    assert camera.matrix[0, 0] == pytest.approx(520, rel=0.01)


def test_live_needs_a_live_source() -> None:
    assert catalogue()["cameras.video"]
    for source in (None, StageUse("cameras.video", {})):
        with pytest.raises(InputError, match=r"camera cam0 has no live source\n.*cameras.device"):
            next(live_pictures(lens(source=source)))


def test_ctrl_c_ends_a_live_camera_with_what_was_seen() -> None:
    picture = Photographer(lens(), BOARD).picture(places(0.45, (0.3, 0.2), 1)[0])

    def interrupted() -> Iterator[tuple[int, Array]]:
        yield 0, picture
        raise KeyboardInterrupt

    assert len(collect("cam0", interrupted(), None, Detector(BOARD), io.StringIO()).views) == 1


def playing(folder: Path) -> Camera:
    """A camera whose live source shows a board at eight places."""
    photographer = Photographer(lens(), BOARD)
    film = cv2.VideoWriter(str(folder / "board.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30, SIZE)
    for place in places(0.42, (0.35, 0.25), 8):
        film.write(cv2.cvtColor(photographer.picture(place), cv2.COLOR_GRAY2BGR))
    film.release()
    return lens(source=StageUse("cameras.playback", {"path": "board.avi", "speed": 1000}))


def test_a_camera_of_the_room_is_calibrated_live(tmp_path: Path) -> None:
    """A recording that plays as a live camera does, from the room file to the lens in it."""
    camera = replace(playing(tmp_path), matrix=np.eye(3))
    save(Room("studio", {camera.name: camera}), tmp_path / "room.yaml")
    assert intrinsics(tmp_path, "--live") == 0
    found = load(tmp_path / "room.yaml").cameras[camera.name]
    assert found.matrix[0, 0] == pytest.approx(lens().matrix[0, 0], rel=0.02)
    assert found.source is not None
    assert found.source.uses == "cameras.playback"


def test_a_missing_device_is_told_at_once_and_the_others_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camera = playing(tmp_path)
    save(Room("studio", {camera.name: camera}), tmp_path / "room.yaml")
    assert intrinsics(tmp_path, "--live", "--device", "absent=77") == 1
    told = capsys.readouterr()
    assert "absent: its camera gives no pictures: is it connected, and free?" in told.err
    assert camera.name in told.out
    assert list(load(tmp_path / "room.yaml").cameras) == [camera.name]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_terminal_shows_the_coverage_and_is_left_clean() -> None:
    pictures = enumerate(map(Photographer(lens(), BOARD).picture, places(0.45, (0.3, 0.2), 2)))
    terminal = Terminal()
    collect("cam0", iter(pictures), 2, Detector(BOARD), terminal)
    text = terminal.getvalue()
    assert "cam0: 2 views in 2 of 2 pictures" in text
    assert "still missing: " in text
    assert text.endswith("\x1b[2K"), "the last line is wiped"
    drawn, wiped = text.count("\n"), text.count("\x1b[1A")
    assert drawn == wiped > 0, "every line is drawn over or wiped"

    collect("cam0", iter([]), 0, Detector(BOARD), nothing := Terminal())
    assert not re.sub(r"\x1b\[[?\d;]*[A-Za-z]", "", nothing.getvalue()).strip()


def test_pictures_of_two_sizes_are_refused() -> None:
    pictures = [(0, np.zeros((480, 640), "u1")), (1, np.zeros((240, 320), "u1"))]
    with pytest.raises(InputError, match="picture 1 is 320x240 px, those before it 640x480"):
        collect("cam0", iter(pictures), 2, Detector(BOARD), io.StringIO())


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures of a board in one camera."""
    folder, photographer = tmp_path_factory.mktemp("cam0"), Photographer(lens(), BOARD)
    for number, place in enumerate(places(0.42, (0.35, 0.25), 10)):
        cv2.imwrite(str(folder / f"{number}.png"), photographer.picture(place))
    return folder


@pytest.fixture
def boards(tmp_path: Path, pictures: Path) -> Path:
    """A folder with the pictures of one camera."""
    (tmp_path / "boards").mkdir()
    (tmp_path / "boards/cam0").symlink_to(pictures)
    return tmp_path


def intrinsics(folder: Path, *more: str) -> int:
    room = ["--room", str(folder / "room.yaml")]
    return main(["calibrate", "intrinsics", *room, "--board", CHARUCO, *more])


def test_command_makes_a_room_file(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert intrinsics(boards, "--videos", str(boards / "boards"), "--json") == 0
    answer = json.loads(capsys.readouterr().out)["cam0"]
    camera = load(boards / "room.yaml").cameras["cam0"]
    assert (camera.size, camera.model, camera.kind) == (SIZE, "pinhole", "color")
    np.testing.assert_array_equal(camera.matrix, answer["matrix"])
    assert answer["rms_px"] < 0.15
    assert len(answer["views"]) == 10
    assert answer["coverage"]["share"] > 0.4


def test_command_replaces_the_lens_and_nothing_else(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = lens(kind="infrared", translation=np.array([1.0, 2.0, 3.0]), host="pc", size=(320, 240))
    save(Room("r", {"cam0": before, "cam1": lens(name="cam1")}), boards / "room.yaml")
    text = (boards / "room.yaml").read_text()
    (boards / "room.yaml").write_text(f"# mine\n{text}")
    assert intrinsics(boards, "--clip", f"cam0={boards / 'boards/cam0'}") == 0
    after = load(boards / "room.yaml").cameras
    np.testing.assert_array_equal(after["cam0"].translation, [1, 2, 3])
    np.testing.assert_array_equal(after["cam1"].matrix, lens().matrix)
    assert (after["cam0"].kind, after["cam0"].host, after["cam0"].size) == ("infrared", "pc", SIZE)
    assert (boards / "room.yaml").read_text().startswith("# mine\n")
    told = capsys.readouterr()
    assert "cam0: its pose was found with another lens" in told.err
    assert f"the page to look at: {boards / 'room.intrinsics.html'}" in told.out
    page = (boards / "room.intrinsics.html").read_text()
    assert "cam0: its pose was found with another lens" in page
    assert "10 of 10" in page


def test_command_names_the_camera_without_a_board(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (boards / "boards/cam1").mkdir()
    cv2.imwrite(str(boards / "boards/cam1/0.png"), np.zeros((480, 640), "u1"))
    assert intrinsics(boards, "--videos", str(boards / "boards")) == 1
    error = capsys.readouterr().err
    assert "cam1: 0 usable views of the board, at least 3 are needed (1 pictures searched)" in error
    assert list(load(boards / "room.yaml").cameras) == ["cam0"]


def test_views_of_another_board_give_no_lens_that_a_room_file_would_refuse() -> None:
    other = parse_board("charuco:5x7:0.04:DICT_4X4_50")
    told = (
        r"no lens explains the views: the best has a focal length of \S+ px, distortion coefficients up to \d"
    )
    with pytest.raises(NoFit, match=told):
        calibrate_lens("cam0", seen(lens(), tilt=0.1), other, SIZE, "pinhole")


def test_a_lens_that_explains_nothing_is_none_though_its_numbers_are_small() -> None:
    """The corners of each view belong to other corners of the board: the best lens errs by 40 px or more."""
    rng = np.random.default_rng(0)
    mixed = [replace(view, label=rng.permutation(view.label)) for view in seen(lens())]
    with pytest.raises(NoFit, match=r"no lens .* an error of [4-9]\d px; is --model pinhole right\?$"):
        calibrate_lens("cam0", mixed, BOARD, SIZE, "pinhole")


def test_command_asks_for_the_board_if_the_search_for_a_lens_runs_away(
    boards: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("followspot_calibrate.intrinsics.calibration.MOST_DISTORTION", 1e-9)
    assert intrinsics(boards, "--videos", str(boards / "boards")) == 1
    error = capsys.readouterr().err
    assert "cam0: no lens explains the views" in error
    assert "is --board charuco:7x5:0.04:DICT_4X4_50 right?" in error
    assert not (boards / "room.yaml").exists()


def test_command_takes_the_chosen_cameras_only(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = str(boards / "boards/cam0")
    clips = ["--clip", f"left={clip}", "--clip", f"right={clip}"]
    assert intrinsics(boards, *clips, "--camera", "middle") == 2
    assert "--camera middle: no pictures of it are given" in capsys.readouterr().err
    assert intrinsics(boards, "--videos", str(boards / "boards"), "--camera", "cam0", "cam1") == 2
    assert "--camera cam1: no pictures of it are given" in capsys.readouterr().err
    assert not (boards / "room.yaml").exists()
    assert intrinsics(boards, *clips, "--camera", "right") == 0
    assert list(load(boards / "room.yaml").cameras) == ["right"]


def test_command_takes_one_recording_of_a_camera(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = f"cam0={boards / 'boards/cam0'}"
    assert intrinsics(boards, "--clip", clip, "--clip", clip) == 2
    assert "cam0 has another recording" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--live", "--videos", "x"], "or live cameras (--live, --device), one of them"),
        (["--device", "cam0"], "--device cam0 is no CAMERA=DEVICE"),
        (["--device", "cam0=0", "--size", "big"], "--size big is no WIDTHxHEIGHT"),
        (["--live"], "has no cameras"),
        ([], "give recordings"),
        (["--live", "--camera", "x"], 'has no camera "x"'),
        (["--videos", "nowhere"], "nowhere is not a folder"),
        (["--clip", "cam0"], "--clip cam0: this is no CAMERA=PATH"),
        (["--clip", "cam0=nowhere"], "nowhere is not there"),
        (["--videos", "x", "--pictures", "0"], "--pictures 0 is less than 1"),
    ],
)
def test_command_refuses_what_it_cannot_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], complaint: str
) -> None:
    assert intrinsics(tmp_path, *arguments) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "room.yaml").exists()


@needs_data("room-pose2sim-single-4cam")
def test_chessboards_of_a_real_room_give_the_published_lens(tmp_path: Path) -> None:
    """The focal length that another program found from the same seven pictures, to 0.2 %."""
    folder = dataset("room-pose2sim-single-4cam") / "intrinsics/int_cam02_img"
    room = tmp_path / "room.yaml"
    arguments = ["--clip", f"cam02={folder}", "--board", "chessboard:7x4:0.06"]
    assert main(["calibrate", "intrinsics", "--room", str(room), *arguments]) == 0
    camera = load(room).cameras["cam02"]
    assert camera.size == (1088, 1920)
    assert camera.matrix[0, 0] == pytest.approx(1675.7, rel=2e-3)
    assert camera.matrix[0, 2] == pytest.approx(555.8, abs=5)
    assert camera.distortion[0] == pytest.approx(-0.052, abs=0.02)


@needs_data("calib-charuco-4cam-caliscope")
def test_inverted_charuco_on_video_gives_a_lens_near_the_given_one(tmp_path: Path) -> None:
    folder = dataset("calib-charuco-4cam-caliscope") / "calibration/extrinsic"
    room = tmp_path / "room.yaml"
    board = "charuco:4x5:0.054:DICT_4X4_1000:inverted"
    arguments = ["--videos", str(folder), "--camera", "cam_0", "--board", board, "--pictures", "60"]
    assert main(["calibrate", "intrinsics", "--room", str(room), *arguments]) == 0
    camera = load(room).cameras["cam_0"]
    assert camera.size == (1280, 720)
    assert camera.matrix[0, 0] == pytest.approx(903.6, rel=0.03)

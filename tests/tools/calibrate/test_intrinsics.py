"""`calibrate intrinsics`: lenses from pictures of boards."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.drawn_boards import Photographer, lens, places
from tests.tools.calibrate.intrinsics_command import BOARD, SIZE

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.room import Camera
from followspot.room_file import load
from followspot_calibrate.boards.board import parse_board
from followspot_calibrate.boards.detection import Detector, View
from followspot_calibrate.intrinsics.calibration import calibrate_lens
from followspot_calibrate.intrinsics.collecting import collect
from followspot_calibrate.intrinsics.coverage import Coverage, coverage
from followspot_calibrate.intrinsics.fitting import NoFit, fit
from followspot_calibrate.intrinsics.selection import diverse, sharp


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

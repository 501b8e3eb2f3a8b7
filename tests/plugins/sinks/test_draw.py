"""What is drawn into pictures: persons, boxes, tracks, search regions, blobs, and a grid of cameras."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.plugins.sinks.drawn import ROOM, SIZE, camera, drawn, frame, poses

from followspot import Context, Room, Target
from followspot.geometry import project
from followspot.messages import stamped
from followspot.people import Boxes
from followspot.testing import check_stage
from followspot.tracking import LOST, TRACKED, Blobs, Forecast, Frame, Tracks
from followspot_sinks.draw import Draw
from followspot_sinks.picture_files import side_by_side
from followspot_sinks.pose_drawing import arrows, images, outline
from followspot_sinks.target_drawing import PALETTE, target_color


def boxes(*corners: float) -> Boxes:
    none = np.zeros((1, 0))
    return Boxes(camera="left", box=np.array([corners]), score=np.ones(1), torso=none, head=none)


def picture(folder: Path, name: str = "left", seq: int = 0) -> np.ndarray:
    found = cv2.imread(str(folder / name / f"{seq:06d}.png"))
    assert found is not None
    return found


def extent(image: np.ndarray) -> tuple[int, int, int, int]:
    rows, columns = np.nonzero(image.any(axis=2))
    return int(columns.min()), int(rows.min()), int(columns.max()), int(rows.max())


@pytest.mark.thorough
def test_stage_keeps_the_promises_of_stages() -> None:
    check_stage(Draw)


def test_outline_begins_at_the_head_is_as_wide_as_shoulders_and_narrower_from_the_side() -> None:
    eye = np.array([0.0, 0.0, 1.2])
    front = outline(np.array([3.0, 0.0]), 1.75, np.pi, eye)
    side = outline(np.array([3.0, 0.0]), 1.75, np.pi / 2, eye)
    assert front[:, 2].max() == 1.75
    assert np.ptp(front[:, 1]) == pytest.approx(0.44)
    assert np.ptp(side[:, 1]) == pytest.approx(0.24)
    np.testing.assert_allclose(front[:, 0], 3.0)
    child = outline(np.array([3.0, 0.0]), 0.875, np.pi, eye)
    assert np.ptp(child[:, 1]) == pytest.approx(0.22)


def test_arrows_point_where_chest_and_face_do() -> None:
    head, chest = arrows(np.array([1.0, 2.0]), 1.75, 0.0, np.pi / 2, 0.0)
    np.testing.assert_allclose(head[1] - head[0], [0, 0.35, 0], atol=1e-12)
    np.testing.assert_allclose(chest[1] - chest[0], [0.45, 0, 0], atol=1e-12)
    raised = arrows(np.array([1.0, 2.0]), 1.75, 0.0, 0.0, np.pi / 6)[0]
    assert raised[1, 2] - raised[0, 2] == pytest.approx(0.175)


def test_line_is_broken_at_the_seam_of_a_panorama_and_behind_a_pinhole() -> None:
    behind = np.array([[-2.0, 0.4, 1.2], [-2.0, 0.2, 1.2], [-2.0, -0.2, 1.2], [-2.0, -0.4, 1.2]])
    runs = list(images(camera(model="cylinder"), behind))
    assert [len(run) for run in runs] == [2, 2]
    assert all(np.ptp(run[:, 0]) < 20 for run in runs)
    assert list(images(camera(), behind)) == []


def test_pose_is_drawn_where_the_person_stands(tmp_path: Path) -> None:
    image = picture(drawn(tmp_path, ROOM, (frame(),), (poses(),)))
    left, _, right, bottom = extent(image[200:])
    top_of_head, shoulder = project(camera(), np.array([[3, 0, 1.75], [3, 0.22, 1.33]]))
    assert abs(left - shoulder[0]) <= 3
    assert abs(right - (SIZE[0] - 1 - shoulder[0])) <= 3
    assert extent(image)[1] < top_of_head[1] < 200 + bottom


def test_pose_of_one_camera_is_not_drawn_in_another_and_a_fused_one_is_in_all(tmp_path: Path) -> None:
    frames = (frame(), frame(name="right"))
    one = drawn(tmp_path / "one", ROOM, frames, (poses("left"),))
    assert picture(one).any()
    assert not picture(one, "right").any()
    fused = drawn(tmp_path / "fused", ROOM, frames, (poses(""),))
    assert picture(fused).any()
    np.testing.assert_array_equal(picture(fused), picture(fused, "right"))


def test_person_behind_the_camera_is_not_drawn(tmp_path: Path) -> None:
    assert not picture(drawn(tmp_path, ROOM, (frame(),), (poses(place=(-3.0, 0.0)),))).any()


def test_box_beyond_the_edge_of_a_panorama_goes_on_at_its_other_end(tmp_path: Path) -> None:
    room = Room(cameras={"left": camera(model="cylinder")})
    image = picture(drawn(tmp_path, room, (frame(size=(628, 200)),), (), (boxes(600, 50, 660, 120),)))
    assert image[80, 600].any()
    assert image[80, 32].any()


def test_track_is_a_circle_as_large_as_its_target(tmp_path: Path) -> None:
    tracks = Tracks(
        target=np.zeros(1, "i4"),
        state=np.ones(1, "u1"),
        xyz=np.array([[2.0, 0.0, 1.2]]),
        velocity=np.zeros((1, 3)),
        sigma=np.zeros((1, 3)),
    )
    image = picture(drawn(tmp_path, ROOM, (frame(),), (), (), (tracks,)))
    left = extent(image)[0]
    assert abs(left - (319.5 - 23)) <= 3


def forecast(state: int = TRACKED, travel: float = 0.0) -> Forecast:
    place = np.array([[2.0, 0.0, 1.2]])
    return Forecast(
        period=0.1,
        state=np.array([state], "u1"),
        xyz=place,
        velocity=np.zeros((1, 3)),
        covariance=np.zeros((1, 3, 3)),
        last=place,
        before=place - [0, travel, 0],
    )


@pytest.mark.parametrize(("travel", "radius"), [(0.0, 10), (0.04, 10), (0.1, 34.5)])
def test_search_region_is_10_px_or_one_and_a_half_times_the_travel(
    tmp_path: Path, travel: float, radius: float
) -> None:
    image = picture(drawn(tmp_path, ROOM, (frame(),), (), (), (), (), forecast(travel=travel)))
    left, top, right, bottom = extent(image)
    assert (right - left) / 2 == pytest.approx(radius, abs=1.5)
    assert (left + right) / 2 == pytest.approx(319.5, abs=1)
    assert (top + bottom) / 2 == pytest.approx(239.5, abs=1)
    assert image[:, :, 0].max() < 30 < image[:, :, 1].max()  # yellow


def test_a_lost_target_has_no_search_region(tmp_path: Path) -> None:
    assert not picture(drawn(tmp_path, ROOM, (frame(),), (), (), (), (), forecast(LOST))).any()


def test_blob_is_a_red_circle_of_its_area_in_the_picture_of_its_camera(tmp_path: Path) -> None:
    place = np.array([[100.0, 50.0]])
    seen = Blobs(
        camera="left",
        xy=place,
        pixel=place,
        area=np.array([314.0]),
        similarity=np.ones(1),
        targets=np.ones((1, 1), bool),
    )
    folder = drawn(tmp_path, ROOM, (frame(), frame(name="right")), (), (), (), (seen,))
    assert extent(picture(folder)) == pytest.approx((90, 40, 110, 60), abs=1)
    assert picture(folder)[:, :, 2].max() > 200
    assert not picture(folder, "right").any()


def test_target_has_the_color_of_its_template_and_of_the_palette_without() -> None:
    green = np.zeros(16)
    green[5] = 1.0
    b, g, r = target_color(Target("green", 0.1, {"left": green}), 3)
    assert g > 200 > max(b, r)
    assert target_color(Target("any", 0.1), 7) == PALETTE[1]


def test_all_cameras_side_by_side_are_one_picture_and_a_silent_one_is_black(tmp_path: Path) -> None:
    sent = frame(name="right")
    sent = stamped(Frame(camera="right", pixels=sent.pixels + 90), sent.header)
    sink = Draw(Context(room=ROOM, out=tmp_path), format="png", layout="grid")
    sink.setup()
    sink.process((sent,))
    sink.close()
    image = picture(tmp_path / "drawn", "all")
    assert image.shape == (480, 1280, 3)
    assert not image[:, :640].any()
    assert (image[:, 640:] == 90).all()


def test_grid_has_a_cell_for_the_largest_of_six_pictures() -> None:
    pictures = [np.full((20 + i, 30, 3), 10 * i + 10, "u1") for i in range(6)]
    grid = side_by_side(pictures)
    assert grid.shape == (50, 90, 3)
    assert grid[[0, 0, 0, 25, 25, 25], [0, 30, 60, 0, 30, 60], 0].tolist() == [10, 20, 30, 40, 50, 60]


def test_infrared_picture_is_drawn_on_in_color(tmp_path: Path) -> None:
    image = picture(drawn(tmp_path, ROOM, (frame(channels=1),), (poses(),)))
    assert (image.max(axis=2) != image.min(axis=2)).any()


def test_pictures_that_were_sent_stay_as_they_are(tmp_path: Path) -> None:
    sent = frame()
    drawn(tmp_path, ROOM, (sent,), (poses(),))
    assert not sent.pixels.any()

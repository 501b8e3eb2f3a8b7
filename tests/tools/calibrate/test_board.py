"""`calibrate board`: where cameras stand, from a board that pairs of them see."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.board_views import BOARD, apart, standing, unknown
from tests.tools.calibrate.drawn_boards import Place, lens

from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera
from followspot_calibrate.board.chain import chained
from followspot_calibrate.board.poses import BoardPose, Relation, board_poses, relate
from followspot_calibrate.board.rigidity import distances
from followspot_calibrate.board.solving import solve
from followspot_calibrate.board.text import warnings_of
from followspot_calibrate.boards.board import parse_board
from followspot_calibrate.boards.detection import View
from followspot_calibrate.similarity import Similarity


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


def test_cameras_that_share_many_views_and_contradict_each_other_are_not_asked_for_more() -> None:
    pose = Similarity(np.eye(3), np.array([1.0, 0.0, 0.0]))
    with pytest.raises(FollowspotError, match=r"agree on 1 of the 40 moments .* out of step .* mirrored"):
        chained(["left", "right"], {(0, 1): Relation(pose, 1, 40)})

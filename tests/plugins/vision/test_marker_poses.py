"""Poses of markers in the room, from their corners."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.plugins.vision.marker_room import GRAPHS, ROOM, SIZE

import followspot as fs
from followspot import Camera, Context
from followspot.geometry import project, undistort
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.testing import check_stage
from followspot_sim.marker_camera import MarkerCamera, marker_pose
from followspot_sim.marker_truth import MarkerTruth
from followspot_vision.aruco import Aruco
from followspot_vision.marker_messages import Markers
from followspot_vision.marker_poses import FindMarkerPoses
from followspot_vision.square_pose import poses, quaternion, square

SECOND = 1_000_000_000


def turned(quaternions: np.ndarray) -> np.ndarray:
    """The rotation of a quaternion w, x, y, z."""
    w, *xyz = quaternions
    return cv2.Rodrigues(
        np.array(xyz) / max(np.linalg.norm(xyz), 1e-300) * 2 * np.arctan2(np.linalg.norm(xyz), w)
    )[0]


def leaning(tilt: float, turn: float = 0.0) -> np.ndarray:
    up, side = cv2.Rodrigues(np.array([0, 0, turn]))[0], cv2.Rodrigues(np.array([tilt, 0, 0]))[0]
    return up @ side


def seen(
    camera: Camera, rotation: np.ndarray, xyz: Sequence[float], noise: float = 0.0, seed: int = 0
) -> np.ndarray:
    """Corners of a marker without distortion, (4, 2) px."""
    pixel = project(camera, square(SIZE) @ rotation.T + xyz)
    pixel += np.random.default_rng(seed).normal(0, noise, (4, 2))
    return undistort(camera, pixel)


def markers(camera: str, time: float = 0.0, **corners: np.ndarray) -> Markers:
    count = len(corners)
    xy = np.array(list(corners.values())).reshape(-1, 4, 2)
    numbers = np.arange(count, dtype=np.int32)
    message = seal(Markers(camera, tuple(corners), numbers, numbers, xy, xy))
    return stamped(message, Header(f"corners/{camera}", round(30 * time), round(time * SECOND)))


def finder(**params: object) -> FindMarkerPoses:
    stage = FindMarkerPoses(Context(room=ROOM), size=SIZE, **{"corner_sigma": 0.5, **params})
    stage.setup()
    return stage


def test_quaternions_say_the_rotation_whichever_number_is_largest() -> None:
    rng = np.random.default_rng(0)
    turns = [*rng.normal(0, 2, (200, 3)), *np.pi * np.eye(3), *-np.pi * np.eye(3), np.zeros(3)]
    for turn in turns:
        rotation = cv2.Rodrigues(turn)[0]
        found = quaternion(rotation)
        assert found[0] >= 0
        assert abs(found @ found - 1) < 1e-12
        assert np.abs(turned(found) - rotation).max() < 1e-7


@pytest.mark.parametrize("names", [("left",), ("left", "right"), ("left", "right", "top")])
def test_exact_corners_give_the_exact_pose(names: tuple[str, ...]) -> None:
    for tilt, turn in ((0.0, 0.0), (0.5, 1.0), (-0.6, 2.5)):
        rotation, xyz = leaning(tilt, turn), [0.3, -0.2, 1.1]
        cameras = [ROOM.cameras[name] for name in names]
        best, *_ = poses(cameras, np.array([seen(camera, rotation, xyz) for camera in cameras]), SIZE)
        assert np.abs(best.rotation - rotation).max() < 1e-5
        assert np.abs(best.xyz - xyz).max() < 1e-5
        assert best.error < 1e-3


def test_more_cameras_give_a_better_pose() -> None:
    errors = {}
    for count in (1, 2, 3):
        cameras = list(ROOM.cameras.values())[:count]
        far = []
        for seed in range(40):
            xy = np.array(
                [seen(c, leaning(0.2), [0, 0, 1], 0.3, 7 * seed + k) for k, c in enumerate(cameras)]
            )
            far.append(np.linalg.norm(poses(cameras, xy, SIZE)[0].xyz - [0, 0, 1]))
        errors[count] = np.median(far)
    assert errors[3] < errors[2] < errors[1] / 3
    assert errors[3] < 0.002


def test_points_have_the_names_of_the_markers_and_honest_covariances() -> None:
    rotation, xyz, sigma = leaning(0.4), np.array([0.1, -0.1, 1.0]), 0.4
    stage, squares = finder(corner_sigma=sigma), []
    for seed in range(150):
        views = [
            markers(name, hat=seen(ROOM.cameras[name], rotation, xyz, sigma, 3 * seed + k))
            for k, name in enumerate(("left", "top"))
        ]
        points = seal(stage.process(tuple(views)).points)
        assert points.labels == ("hat",)
        off = points.xyz[0] - xyz
        squares.append(off @ np.linalg.solve(points.covariance[0], off))
    assert 2.4 < np.mean(squares) < 3.6  # of three numbers each


def facing(camera: Camera, xyz: np.ndarray) -> np.ndarray:
    """The rotation of a marker that faces a camera squarely, where both poses look alike."""
    z = (camera.center - xyz) / np.linalg.norm(camera.center - xyz)
    x = np.cross([0, 0, 1.0], z) / np.linalg.norm(np.cross([0, 0, 1.0], z))
    return np.column_stack([x, np.cross(z, x), z])


def test_a_marker_in_one_camera_does_not_flip_to_the_other_pose() -> None:
    camera, xyz = ROOM.cameras["left"], np.array([0.0, 0.0, 1.0])
    wrong, ambiguity = {}, []
    for memory in (0.0, 1.0):
        stage = finder(memory=memory)
        wrong[memory] = 0
        for frame in range(60):
            rotation = facing(camera, xyz) @ leaning(0.8 - 0.006 * frame)
            found = stage.process(
                (markers("left", frame / 30, hat=seen(camera, rotation, xyz, 0.6, frame)),)
            ).poses
            ambiguity.append(found.ambiguity[0])
            wrong[memory] += int(turned(found.rotation[0])[:, 2] @ rotation[:, 2] < np.cos(0.45))
    assert max(ambiguity) > 0.5
    assert wrong[1.0] == 0 < wrong[0.0]


def test_a_marker_that_began_on_the_wrong_side_is_righted_by_what_is_seen_later() -> None:
    camera, xyz = ROOM.cameras["left"], np.array([0.0, 0.0, 1.0])
    stage, wrong = finder(), []
    for frame in range(60):
        shown = -0.3 if frame < 3 else 0.3
        rotation = facing(camera, xyz) @ leaning(shown)
        found = stage.process(
            (markers("left", frame / 30, hat=seen(camera, rotation, xyz, 0.2, frame)),)
        ).poses
        true = facing(camera, xyz) @ leaning(0.3)
        wrong.append(turned(found.rotation[0])[:, 2] @ true[:, 2] < np.cos(0.3))
    assert all(wrong[:3])
    assert not any(wrong[30:])


def test_the_side_of_a_marker_is_kept_by_a_replacement() -> None:
    camera, xyz = ROOM.cameras["left"], np.array([0.0, 0.0, 1.0])
    rotation = facing(camera, xyz) @ leaning(0.4)
    first = finder(corner_sigma=1.0)
    for frame in range(10):
        first.process((markers("left", frame / 30, hat=seen(camera, rotation, xyz)),))
    kept, fresh, late = [], [], []
    for seed in range(20):
        corners = seen(camera, rotation, xyz, 0.6, seed)
        for found, time, state in (
            (kept, 0.32, first.state()),
            (fresh, 0.32, {}),
            (late, 5.0, first.state()),
        ):
            stage = finder(corner_sigma=1.0)
            stage.restore(state)
            (quaternions,) = stage.process((markers("left", time, hat=corners),)).poses.rotation
            found.append(bool(turned(quaternions)[:, 2] @ rotation[:, 2] > np.cos(0.6)))
    assert all(kept)
    assert not all(fresh)
    assert late == fresh


def test_markers_of_other_sizes_and_false_corners() -> None:
    camera = ROOM.cameras["left"]
    corners = seen(camera, leaning(0.3), [0.1, 0.2, 1.0])
    rng = np.random.default_rng(0)
    bent = corners + rng.normal(0, 15, (4, 2))
    unknown = np.full((4, 2), np.nan)
    right = seen(ROOM.cameras["right"], leaning(0.3), [0.1, 0.2, 1.0])
    found = (
        finder(sizes={"big": 2 * SIZE})
        .process(
            (
                markers("left", hat=corners, big=corners, bent=bent, unknown=unknown),
                markers("right", hat=right),
            )
        )
        .poses
    )
    assert found.names == ("big", "hat")
    assert found.views.tolist() == [1, 2]
    near, far = (np.linalg.norm(xyz - camera.center) for xyz in found.xyz[[1, 0]])
    assert abs(far / near - 2) < 1e-3


def test_a_size_of_a_marker_that_was_never_seen_is_told_at_the_end(caplog: pytest.LogCaptureFixture) -> None:
    corners = seen(ROOM.cameras["left"], leaning(0.3), [0.1, 0.2, 1.0])
    for size, said in (("hta", ["sizes names hta, never seen; markers seen: big, hat"]), ("hat", [])):
        stage = finder(sizes={size: 2 * SIZE})
        stage.process((markers("left", hat=corners, big=corners),))
        stage.close()
        assert [record.getMessage() for record in caplog.records] == said
        caplog.clear()


def test_they_keep_the_promises_of_stages() -> None:
    check_stage(FindMarkerPoses, messages=200)
    check_stage(Aruco, messages=200)
    check_stage(MarkerCamera, frames=3)
    check_stage(MarkerTruth, frames=3)
    check_stage(MarkerTruth, frames=3, markers=0)


def test_the_graph_of_markers_writes_poses_and_tracks_near_the_truth(tmp_path: Path) -> None:
    with fs.run(GRAPHS / "markers.yaml", frames=15, out=tmp_path) as run:
        scores = {row["target"]: row for row in run.wait().accuracy}
    assert set(scores) == {"hat", "chair", "lamp"}
    assert all(row["coverage"] == 1 and row["rmse_mm"] < 3 for row in scores.values())
    off = []
    with (tmp_path / "poses.csv").open() as file:
        for row in csv.DictReader(file):
            rotation, _ = marker_pose(list(ROOM.targets).index(row["marker"]), 3, float(row["time"]))
            found = turned(np.array([float(row[name]) for name in ("qw", "qx", "qy", "qz")]))
            off.append(np.linalg.norm(cv2.Rodrigues(found @ rotation.T)[0]))
    assert len(off) >= 40
    assert np.median(off) < np.radians(1.5)


def test_no_markers_are_no_poses() -> None:
    stage = finder()
    for given in ((), (markers("left"),)):
        found = stage.process(given)
        assert seal(found.poses).names == seal(found.points).labels == ()

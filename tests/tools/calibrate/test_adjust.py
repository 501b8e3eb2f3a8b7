"""Bundle adjustment: exact derivatives, exact recovery, outliers and known lengths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from tests.tools.calibrate.rooms import made_room

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera
from followspot_calibrate.adjust import Anchors, Free, Rods, adjust
from followspot_calibrate.adjust.problem import Estimate, Problem, cauchy_weighted, view_of
from followspot_calibrate.adjust.projection import image, linearise, moved, rotation_of
from followspot_calibrate.adjust.rods import groups_of
from followspot_calibrate.similarity import Similarity

small = st.floats(-0.3, 0.3)
everything = Free(poses=True, focal=True, aspect=True, center=True, distortion=5)


skews = st.sampled_from([0.0, 4.0])


def skewed(camera: Camera, skew: float) -> Camera:
    """The camera with a skew, px."""
    return replace(camera, matrix=camera.matrix + skew * np.outer([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]))


@given(lens=st.tuples(small, small, small, small, small), seed=st.integers(0, 1000), skew=skews)
@settings(max_examples=40, deadline=None)
def test_derivatives_agree_with_finite_differences(lens, seed, skew):
    room = made_room(cameras=2, rows=4, distortion=lens, seed=seed)
    camera, points = skewed(room.cameras[0], skew), room.points
    pixel, by_camera, by_point = linearise(camera, points, everything)
    rounding = 8 * np.finfo(float).eps * np.abs(pixel).max() / 1e-6

    def agree(exact: Array, numeric: Array) -> bool:
        return np.allclose(exact, numeric, rtol=1e-5, atol=1e-5 * np.abs(numeric).max() + rounding)

    for parameter in range(everything.parameters):
        step = np.zeros(everything.parameters)
        step[parameter] = 1e-6
        ahead, behind = (image(moved(camera, sign * step, everything), points) for sign in (1, -1))
        numeric = (ahead - behind) / 2e-6
        assert agree(by_camera[:, :, parameter], numeric)
    for axis in range(3):
        step = 1e-6 * np.eye(3)[axis]
        numeric = (image(camera, points + step) - image(camera, points - step)) / 2e-6
        assert agree(by_point[:, :, axis], numeric)


@given(lens=st.tuples(small, small, small, small, small), skew=skews)
@settings(max_examples=20, deadline=None)
def test_pixels_are_those_of_the_room_geometry(lens, skew):
    room = made_room(cameras=2, rows=5, distortion=lens)
    camera = skewed(room.cameras[1], skew)
    assert np.allclose(image(camera, room.points), project(camera, room.points))


@pytest.mark.parametrize(
    "free", [Free(), Free(focal=True), Free(focal=True, center=True, distortion=2), everything]
)
def test_an_exact_room_is_recovered_exactly(free):
    room = made_room(cameras=4, rows=250)
    start, points = shaken(room, free)
    found = adjust(start, points, room.sightings.pixel, free)
    assert np.nanmax(found.residual) < 1e-6
    turn, shift, scale = similarity(np.array([c.center for c in found.cameras]), centers(room))
    assert scale * found.points @ turn.T + shift == pytest.approx(room.points, abs=1e-6)
    for camera, true in zip(found.cameras, room.cameras, strict=True):
        assert camera.rotation @ turn.T == pytest.approx(true.rotation, abs=1e-6)
        assert camera.matrix == pytest.approx(true.matrix, abs=1e-4)
        assert camera.distortion == pytest.approx(true.distortion, abs=1e-6)


def test_known_poses_stay_and_points_move():
    room = made_room(cameras=3, rows=50)
    found = adjust(room.cameras, room.points + 0.05, room.sightings.pixel, Free(poses=False))
    assert [c.translation.tolist() for c in found.cameras] == [c.translation.tolist() for c in room.cameras]
    assert found.points == pytest.approx(room.points, abs=1e-7)


def test_outliers_hardly_pull():
    room = made_room(cameras=5, rows=300, outliers=0.1, noise=0.3)
    start, points = shaken(room, Free(), size=0.2)
    found = adjust(start, points, room.sightings.pixel, Free())
    turn, shift, scale = similarity(np.array([c.center for c in found.cameras]), centers(room))
    moved_back = scale * np.array([c.center for c in found.cameras]) @ turn.T + shift
    assert np.abs(moved_back - centers(room)).max() < 0.005
    kept = np.where(room.outlier, np.nan, found.residual)
    assert np.nanmedian(kept) < 0.5


@given(error=hnp.arrays(float, 2, elements=st.floats(-0.1, 0.1)))
@settings(max_examples=40, deadline=None)
def test_weights_give_the_derivatives_of_the_cauchy_loss(error):
    factor, weighted = cauchy_weighted(error[None])
    square = error @ error
    gradient = error / (1 + square)
    curvature = np.eye(2) / (1 + square) - 2 * np.outer(error, error) / (1 + square) ** 2
    assert factor[0] @ weighted[0] == pytest.approx(gradient)
    assert factor[0] @ factor[0] == pytest.approx(curvature, abs=6 * square**2 + 1e-12)


def test_noise_takes_few_steps():
    """With the weights of the loss alone, 31."""
    room = made_room(cameras=4, rows=250)
    start, points = shaken(room, Free(), size=0.3)
    pixel = room.sightings.pixel + np.random.default_rng(1).normal(0, 0.5, room.sightings.pixel.shape)
    assert adjust(start, points, pixel, Free()).steps < 25


def test_rows_that_cannot_be_adjusted_stay():
    room = made_room(cameras=3, rows=40)
    pixel, points = room.sightings.pixel.copy(), room.points + 0.01
    pixel[0, 1:] = np.nan
    points[1] = np.nan
    found = adjust(room.cameras, points, pixel, Free(poses=False))
    assert found.points[0].tolist() == points[0].tolist()
    assert np.isnan(found.points[1]).all()
    assert np.isnan(found.residual[1]).all()
    assert np.isnan(found.residual[0, 1:]).all()


def test_a_wand_of_known_length_sets_the_scale():
    random = np.random.default_rng(1)
    room = made_room(cameras=4, rows=200)
    along = random.normal(size=(100, 3))
    ends = room.points.copy()
    ends[100:] = ends[:100] + 0.4 * along / np.linalg.norm(along, axis=1, keepdims=True)
    pixel = np.stack([project(camera, ends) for camera in room.cameras], axis=1)
    rods = Rods(np.arange(100), np.arange(100, 200), 0.4, 0.001)
    start = [replace(c, translation=c.translation * 1.1) for c in room.cameras]
    found = adjust(start, ends * 1.1, pixel, Free(), rods=rods)
    assert np.linalg.norm(found.points[:100] - found.points[100:], axis=1) == pytest.approx(0.4, abs=1e-7)
    assert similarity(np.array([c.center for c in found.cameras]), centers(room))[2] == pytest.approx(
        1, abs=1e-6
    )


def test_eliminating_the_points_solves_the_whole_system():
    """Chains of rods, several rods at one point and single points: as if solved at once."""
    room = made_room(cameras=3, rows=30, noise=0.5)
    rods = Rods(np.array([0, 1, 2, 10, 20]), np.array([1, 2, 3, 11, 0]), np.full(5, 1.0), 0.01)
    free, groups = Free(focal=True), groups_of(30, rods)
    seen = [view_of(c, room.sightings.pixel[:, i], free)[1] for i, c in enumerate(room.cameras)]
    problem = Problem(seen, rods, groups, np.ones(30), free.parameters)
    normal = problem.normal(Estimate(room.cameras, room.points))
    by_camera, by_point = normal.solve(groups, 1e-3)
    whole = np.zeros((3 * 7 + 90, 3 * 7 + 90))
    for i, block in enumerate(normal.cameras):
        whole[7 * i : 7 * i + 7, 7 * i : 7 * i + 7] = block
    points = whole[21:, 21:].reshape(30, 3, 30, 3)
    points[np.arange(30), :, np.arange(30)] = normal.points
    for a, b, block in zip(rods.first, rods.second, normal.rods, strict=True):
        points[a, :, b], points[b, :, a] = block, block
    whole[21:, :21] = normal.mixed.reshape(90, 21)
    whole[:21, 21:] = whole[21:, :21].T
    whole[np.diag_indices(111)] *= 1.001
    toward = np.concatenate([normal.toward_cameras.ravel(), normal.toward_points.ravel()])
    step = np.concatenate([by_camera.ravel(), by_point.ravel()])
    assert step == pytest.approx(np.linalg.solve(whole, toward), rel=1e-6, abs=1e-9)


def test_a_fisheye_camera_keeps_its_lens_and_finds_its_pose():
    room = made_room(cameras=4, rows=150, distortion=(0, 0, 0, 0, 0))
    lens = np.array([0.02, -0.005, 0.0, 0.0])
    cameras = (replace(room.cameras[0], model="fisheye", distortion=lens), *room.cameras[1:])
    pixel = np.stack([project(camera, room.points) for camera in cameras], axis=1)
    start = [replace(c, translation=c.translation + 0.02 * i) for i, c in enumerate(cameras)]
    found = adjust(start, room.points, pixel, Free())
    assert np.nanmax(found.residual) < 1e-6
    assert found.cameras[0].model == "fisheye"
    assert found.cameras[0].distortion.tolist() == lens.tolist()


def test_points_that_are_less_exact_count_less():
    """Half of the points are 20 times as noisy: told so, the cameras come nearer to where they are."""
    room = made_room(cameras=4, rows=200, outliers=0.0)
    noise = np.repeat([0.1, 2.0], 100)
    exact = np.stack([project(camera, room.points) for camera in room.cameras], axis=1)
    pixel = exact + np.random.default_rng(2).normal(size=exact.shape) * noise[:, None, None]
    away = {}
    for name, scale in (("one scale", 2.0), ("own scales", 2.4 * noise)):
        found = adjust(room.cameras, room.points, pixel, Free(), scale=scale)
        moved = similarity(centers(found), centers(room))
        away[name] = np.linalg.norm(moved[2] * centers(found) @ moved[0].T + moved[1] - centers(room))
    assert away["own scales"] < away["one scale"] / 2


def test_the_derivative_of_anchors_is_that_of_the_formula():
    cameras = made_room(cameras=3, rows=5).cameras
    anchors = Anchors(np.zeros((3, 3)), np.array([0.1, 0.2, 0.5]))
    rows, size = anchors.by_pose(cameras), 1e-6
    for k in range(6):
        stepped = [moved(camera, size * np.eye(6)[k], Free()) for camera in cameras]
        numeric = (anchors.errors(stepped) - anchors.errors(cameras)) / size
        assert rows[:, :, k] == pytest.approx(numeric, abs=1e-4)


def test_known_centres_hold_cameras_and_set_the_frame():
    """A room that is elsewhere and too large comes to where three centres are known to be."""
    room = made_room(cameras=4, rows=200)
    move = Similarity(rotation_of(np.array([0.0, 0.0, 0.05])), np.array([0.1, 0.0, 0.2]), 1.05)
    anchors = Anchors(centers(room), np.array([0.001, 0.001, 0.001, np.inf]))
    start = [move.camera(camera) for camera in room.cameras]
    found = adjust(start, move.points(room.points), room.sightings.pixel, Free(), anchors=anchors)
    assert centers(found) == pytest.approx(centers(room), abs=1e-5)
    assert found.points == pytest.approx(room.points, abs=1e-5)


@pytest.mark.parametrize(("count", "scale"), [(3, 1.0), (0, 0.0)])
def test_nonsense_is_refused(count, scale):
    room = made_room(cameras=2, rows=5)
    with pytest.raises(ValueError, match=r"scale|distortion"):
        adjust(room.cameras, room.points, room.sightings.pixel, Free(distortion=count), scale=scale)


def shaken(room, free: Free, size: float = 1.0):
    """A start near the truth: poses, points and free intrinsics off by a little."""
    random = np.random.default_rng(5)
    start = []
    for camera in room.cameras:
        step = np.zeros(free.parameters)
        step[:6] = size * random.normal(0, [0.03] * 3 + [0.05] * 3)
        step[6:7] = 0.02
        start.append(moved(camera, step, free))
    return start, room.points + random.normal(0, 0.05 * size, room.points.shape)


def centers(room) -> Array:
    return np.array([c.center for c in room.cameras])


def similarity(source: Array, target: Array) -> tuple[Array, Array, float]:
    """Umeyama 1991: target = scale R source + shift."""
    a, b = source - source.mean(0), target - target.mean(0)
    U, s, Vt = np.linalg.svd(b.T @ a)
    sign = np.diag([1, 1, np.linalg.det(U @ Vt)])
    scale = float(np.trace(np.diag(s) @ sign) / np.square(a).sum())
    turn = U @ sign @ Vt
    return turn, target.mean(0) - scale * turn @ source.mean(0), scale

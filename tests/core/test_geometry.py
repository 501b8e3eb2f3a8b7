"""Camera models, pair relations and triangulation against exact values and their own inverses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.geometry import (
    Views,
    back_projection,
    distort,
    epipolar_distance,
    fundamental_matrix,
    plane_homography,
    project,
    project_local,
    ray,
    transfer,
    triangulate_pairs,
    triangulate_views,
    undistort,
)
from followspot.lens import fold
from followspot.messages import Array
from followspot.room import Camera, LensModel

K = np.array([[200.0, 0.0, 160.0], [0.0, 210.0, 120.0], [0.0, 0.0, 1.0]])
LENS = {
    "pinhole": np.array([-0.26, 0.08, -0.0012, 0.0008, -0.004]),
    "rational": np.array([0.54, -2.62, 0.0007, -0.0002, 1.53, 0.42, -2.43, 1.45]),
    "fisheye": np.array([0.05, -0.01, 0.004, -0.001]),
    "cylinder": np.zeros(0),
}


def rotation(angles: tuple[float, float, float]) -> Array:
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    Rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(Rz @ Ry @ Rx)


def camera(
    model: LensModel = "pinhole",
    distortion: Array | None = None,
    angles: tuple[float, float, float] = (0.0, 0.0, 0.0),
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Camera:
    lens = LENS[model] if distortion is None else distortion
    return Camera("c", "color", (320, 240), K, lens, rotation(angles), np.array(translation), model=model)


IDEAL = np.zeros(5)
pixels = st.lists(st.tuples(st.floats(0, 319), st.floats(0, 239)).map(list), min_size=1, max_size=8).map(
    np.array
)
angles = st.tuples(*[st.floats(-0.6, 0.6)] * 3)
models = st.sampled_from(["pinhole", "rational", "fisheye", "cylinder"])


def test_pinhole_projects_by_hand() -> None:
    # x = 200 * 1 / 4 + 160, y = 210 * -0.5 / 4 + 120
    assert project(camera(distortion=IDEAL), np.array([[1.0, -0.5, 4.0]])) == pytest.approx(
        np.array([[210.0, 93.75]]), abs=1e-12
    )


def test_distortion_follows_opencv_order_k1_k2_p1_p2_k3() -> None:
    # x = 0.5, y = 0: r2 = 0.25, radial = 1 + 0.1 r2; x' = 0.5 radial + p2 (r2 + 2 x2), y' = p1 r2
    lens = np.array([0.1, 0.0, 0.02, 0.04, 0.0])
    expected = [200 * (0.5 * 1.025 + 0.04 * 0.75) + 160, 210 * 0.02 * 0.25 + 120]
    assert project(camera(distortion=lens), np.array([[0.5, 0.0, 1.0]]))[0] == pytest.approx(expected)


def test_fisheye_image_is_proportional_to_the_angle() -> None:
    seen = project(camera("fisheye", np.zeros(4)), np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
    assert seen[:, 0] == pytest.approx([160 + 200 * np.pi / 4, 160 + 200 * np.pi / 2])


def test_cylinder_unrolls_the_angle_around_its_axis() -> None:
    seen = project(camera("cylinder"), np.array([[1.0, 1.0, 1.0], [0.0, 0.5, -1.0]]))
    assert seen[0] == pytest.approx([160 + 200 * np.pi / 4, 120 + 210 / np.sqrt(2)])
    assert seen[1] == pytest.approx([160 + 200 * np.pi, 120 + 105])


@pytest.mark.parametrize("model", ["pinhole", "rational", "fisheye", "cylinder"])
def test_a_skewed_matrix_shears_the_picture_of_every_lens(model: LensModel) -> None:
    # x = fx x' + s y' + cx for the distorted point (x', y') (H&Z, eq. 6.10)
    straight = camera(model, translation=(0.1, 0.2, 0.0))
    skewed = replace(straight, matrix=np.array([[K[0, 0], 7.0, K[0, 2]], K[1], K[2]]))
    points = np.array([[1.0, -0.5, 4.0], [-0.3, 1.1, 3.0]])
    expected = project(straight, points)
    expected[:, 0] += 7.0 * (expected[:, 1] - K[1, 2]) / K[1, 1]
    seen = project(skewed, points)
    assert seen == pytest.approx(expected, abs=1e-9)
    assert Views([skewed]).project_local(Views([skewed]).local(points))[0] == pytest.approx(seen, abs=1e-9)
    assert ray(skewed, seen) == pytest.approx(ray(straight, project(straight, points)), abs=1e-9)
    image = np.column_stack([points, np.ones(2)]) @ skewed.projection.T
    assert undistort(skewed, seen) == pytest.approx(image[:, :2] / image[:, 2:], abs=1e-6)
    assert distort(skewed, undistort(skewed, seen)) == pytest.approx(seen, abs=1e-6)


def test_points_behind_a_pinhole_camera_have_no_image() -> None:
    assert np.isnan(project(camera(), np.array([[0.1, 0.1, -1.0]]))).all()


@settings(deadline=None, max_examples=60)
@given(pixels, st.sampled_from(["pinhole", "fisheye"]))
def test_undistorting_and_distorting_gives_the_pixel_back(pixel: Array, model: LensModel) -> None:
    lens = camera(model)
    assert np.abs(distort(lens, undistort(lens, pixel)) - pixel).max() < 1e-6


@settings(deadline=None, max_examples=60)
@given(pixels, models, angles)
def test_points_along_a_ray_project_to_its_pixel(
    pixel: Array, model: LensModel, turn: tuple[float, float, float]
) -> None:
    view = camera(model, angles=turn, translation=(0.3, -0.2, 1.0))
    directions = ray(view, pixel)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(np.ones(len(pixel)))
    assert np.abs(project(view, view.center + 2.5 * directions) - pixel).max() < 1e-6


def test_several_views_show_what_each_camera_shows() -> None:
    cameras = [camera("pinhole", angles=(0.2, -0.1, 0.3), translation=(0.1, 0.2, 3.0)), camera("fisheye")]
    views = Views([*cameras, camera("cylinder")])
    points = np.array([[0.1, 0.2, 0.5], [-0.4, 0.3, 1.0], [0.0, 0.0, -9.0]])
    pixel = views.project_local(views.local(points))
    for shown, one in zip(pixel, views.cameras, strict=True):
        assert shown == pytest.approx(project(one, points), nan_ok=True)


def test_no_points_are_no_points() -> None:
    for model in ("pinhole", "fisheye", "cylinder"):
        view = camera(model)
        assert project(view, np.empty((0, 3))).shape == (0, 2)
        assert undistort(view, np.empty((0, 2))).shape == (0, 2)
        assert ray(view, np.empty((0, 2))).shape == (0, 3)


def test_fundamental_matrix_of_a_sideways_pair_has_horizontal_epipolar_lines() -> None:
    left, right = camera(distortion=IDEAL), camera(distortion=IDEAL, translation=(-1.0, 0.0, 0.0))
    F = fundamental_matrix(left.projection, right.projection)
    one = np.array([[100.0, 80.0], [100.0, 80.0]])
    other = np.array([[40.0, 80.0], [40.0, 84.0]])
    assert epipolar_distance(F, one, other) == pytest.approx([0.0, 4.0], abs=1e-9)


def test_epipolar_distance_is_the_larger_of_both_views() -> None:
    # x2^T F x1 = 3 u1 + v2: line in view 2 is v = -3 u1, in view 1 it is u = -v2 / 3
    F = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0]])
    assert epipolar_distance(F, np.array([[1.0, 5.0]]), np.array([[7.0, 0.0]])) == pytest.approx([3.0])
    assert epipolar_distance(F.T, np.array([[7.0, 0.0]]), np.array([[1.0, 5.0]])) == pytest.approx([3.0])


@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(*[st.floats(-1, 1)] * 2), min_size=1, max_size=5), angles)
def test_homography_maps_the_images_of_a_plane(
    points: list[tuple[float, float]], turn: tuple[float, float, float]
) -> None:
    normal = np.array([0.1, 0.2, -0.9])
    plane = np.append(normal / np.linalg.norm(normal), 3.0)
    a = camera(distortion=IDEAL)
    b = camera(distortion=IDEAL, angles=turn, translation=(0.5, 0.2, 0.7))
    xy = np.array(points)
    X = np.column_stack([xy, -(xy @ plane[:2] + plane[3]) / plane[2]])
    moved = transfer(plane_homography(a, b, plane), project(a, X))
    assert moved == pytest.approx(project(b, X), abs=1e-6)


def test_plane_homography_shifts_a_fronto_parallel_plane_by_the_disparity() -> None:
    a, b = camera(distortion=IDEAL), camera(distortion=IDEAL, translation=(-0.5, 0.0, 0.0))
    H = plane_homography(a, b, np.array([0.0, 0.0, 1.0, -2.0]))  # z = 2 m: 200 * 0.5 / 2 = 50 px
    assert transfer(H, np.array([[160.0, 120.0]])) == pytest.approx(np.array([[110.0, 120.0]]))


@settings(deadline=None, max_examples=40)
@given(st.tuples(*[st.floats(-1, 1)] * 3), angles)
def test_triangulation_gives_exact_points_back(
    point: tuple[float, float, float], turn: tuple[float, float, float]
) -> None:
    views = [
        camera(distortion=IDEAL, angles=turn, translation=(0.1, 0.0, 4.0)),
        camera(distortion=IDEAL, angles=(0.0, 0.8, 0.0), translation=(0.0, 0.2, 4.0)),
        camera(distortion=IDEAL, angles=(0.7, 0.0, 0.1), translation=(0.2, 0.0, 5.0)),
    ]
    X = np.array([point])
    centers = np.array([v.center for v in views])
    rays = np.stack([ray(v, project(v, X)) for v in views], axis=1)
    assert triangulate_pairs(centers[None, :2], rays[:, :2]) == pytest.approx(X, abs=1e-6)
    assert triangulate_views(centers, rays, np.array([[1.0, 2.0, 0.5]])) == pytest.approx(X, abs=1e-6)


def test_rays_that_miss_meet_nearer_to_the_nearer_camera() -> None:
    # skew rays 10 cm apart at depths 1 m and 3 m: shares of the gap are 1 : 9
    centers = np.array([[[0.0, 0.0, 0.0], [1.0, 3.0, 0.1]]])
    rays = np.array([[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]])
    assert triangulate_pairs(centers, rays) == pytest.approx(np.array([[1.0, 0.0, 0.01]]))


def test_rays_that_meet_behind_a_camera_or_never_make_no_point() -> None:
    centers = np.array([[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    rays = np.array([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]])
    assert np.isnan(triangulate_pairs(centers, rays)).all()


def test_a_view_without_weight_does_not_count() -> None:
    centers = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [5.0, 5.0, 5.0]])
    rays = np.array([[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]])
    found = triangulate_views(centers, rays, np.array([[1.0, 1.0, 0.0]]))
    assert found == pytest.approx(np.array([[1.0, 0.0, 0.0]]), abs=1e-12)


def test_back_projection_of_the_principal_point_is_the_optical_axis() -> None:
    view = camera(angles=(0.2, -0.3, 0.1))
    direction = back_projection(view) @ np.array([160.0, 120.0, 1.0])
    assert direction / np.linalg.norm(direction) == pytest.approx(view.rotation[2])


def test_a_camera_has_a_point_in_its_picture_if_the_image_lies_there() -> None:
    """Of each camera model as its image by itself says, and none behind the camera."""
    cameras = [camera(model) for model in ("pinhole", "rational", "fisheye", "cylinder")]
    points = np.random.default_rng(3).uniform(-4, 4, (300, 3))
    shown = Views(cameras).in_pictures(points)
    for one, seen in zip(cameras, shown, strict=True):
        width, height = one.size
        x, y = project(one, points).T
        assert np.array_equal(seen, (x >= 0) & (x < width) & (y >= 0) & (y < height))
        assert 0 < seen.sum() < len(points)
    assert Views([]).in_pictures(points).shape == (0, 300)


@pytest.mark.parametrize("model", ["pinhole", "rational"])
def test_a_place_far_aside_is_in_no_picture_though_the_polynomial_of_the_lens_says_so(
    model: LensModel,
) -> None:
    """Beyond its turning point a polynomial that was fitted to the picture means nothing."""
    zeros = [0.0] * 3 * (model == "rational")
    wide = replace(camera(model), distortion=np.array([-0.3, 0.1, 0.0, 0.0, -0.012, *zeros]))
    aside = np.array([[0.5, 0.0, 1.0], [2.5, 0.0, 1.0], [-2.5, 0.0, 1.0]])  # the lens turns at 2.006
    x, y = project_local(wide, aside).T
    assert ((x > 0) & (x < wide.size[0]) & (y > 0) & (y < wide.size[1])).all()
    room = (aside - wide.translation) @ wide.rotation
    assert Views([wide]).in_pictures(room).tolist() == [[True, False, False]]


def test_only_a_lens_that_turns_has_a_fold() -> None:
    assert fold(camera("fisheye")) == np.inf
    straight, barrel = (replace(camera(), distortion=np.array([k, 0, 0, 0, 0.0])) for k in (0.0, -1 / 3))
    assert fold(straight) == np.inf
    assert fold(barrel) == pytest.approx(1.0)  # r - r^3 / 3 grows until r is 1
    pole = replace(camera("rational"), distortion=np.array([0, 0, 0, 0, 0, -0.25, 0, 0.0]))
    assert fold(pole) == pytest.approx(2.0)

"""Lines of sight, screens, visible shares, and the flags of the ground truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot import room_file
from followspot.geometry import project
from followspot_sim.rendering.ray_casting import closest_approach
from followspot_sim.rendering.screen import lookup, rays_of, screens_of
from followspot_sim.visibility import truth_flags, visible_fraction
from followspot_sim.world import Scene

ROOM = room_file.load(Path(__file__).parents[3] / "graphs/rooms/simulated.yaml")
UNMATCHED = (np.empty((0, 2, 3)), np.empty(0), np.empty(0, int))
RADIUS = np.array([0.0762])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_approach_is_the_smallest_distance_between_ray_and_segment(seed):
    rng = np.random.default_rng(seed)
    origin, ends = rng.normal(size=3), rng.normal(size=(1, 2, 3)) * 3
    ray = rng.normal(size=3)
    ray /= np.linalg.norm(ray)
    distance, along = closest_approach(origin, ray, ends)
    points = ends[0, 0] + np.linspace(0, 1, 20001)[:, None] * (ends[0, 1] - ends[0, 0])
    gaps = np.linalg.norm(np.cross(points - origin, ray), axis=1)
    assert distance[0] == pytest.approx(gaps.min(), abs=1e-3)
    assert along[0] == pytest.approx((points[gaps.argmin()] - origin) @ ray, abs=0.05 + 1e-2 * gaps.min())


@pytest.mark.parametrize("camera", ROOM.cameras.values(), ids=ROOM.cameras)
def test_a_free_ball_in_the_middle_of_the_room_is_wholly_visible(camera):
    scene = Scene(0.0, np.array([[0.0, 0.0, 1.0]]), *UNMATCHED)
    assert visible_fraction([camera], scene, RADIUS)[0, 0] == 1.0


@pytest.mark.parametrize("camera", ROOM.cameras.values(), ids=ROOM.cameras)
def test_a_ball_inside_a_bag_is_visible_in_no_camera(camera):
    ball = np.array([[0.3, -0.2, 0.8]])
    bag = np.array([[[0.3, -0.2, 0.74], [0.3, -0.2, 0.84]]])
    scene = Scene(0.0, ball, bag, np.array([0.13]), np.array([3]))
    assert visible_fraction([camera], scene, RADIUS)[0, 0] == 0.0


def test_a_ball_half_behind_another_is_half_visible():
    camera = ROOM.cameras["cam0"]
    away = np.array([0.0, 0.0, 1.0]) - camera.center
    side = np.cross(away, [0, 0, 1.0])
    side *= 0.0762 / np.linalg.norm(side)
    balls = np.array([[0.0, 0.0, 1.0], camera.center + 0.9 * away + side])
    seen = visible_fraction([camera], Scene(0.0, balls, *UNMATCHED), np.repeat(RADIUS, 2))[0]
    assert seen[1] == 1.0
    assert 0.3 < seen[0] < 0.7


def test_a_ball_across_the_edge_of_the_picture_counts_what_is_inside():
    camera = ROOM.cameras["cam0"]
    ray = rays_of(camera)[120, 0]
    half = visible_fraction([camera], Scene(0.0, (camera.center + 4 * ray)[None], *UNMATCHED), RADIUS)[0, 0]
    assert 0.4 < half < 0.7


def test_flags_follow_the_definition_of_truth():
    cameras = [ROOM.cameras[name] for name in ("cam0", "cam2", "cam1")]
    table = [  # visible share in two colour cameras and an infrared one; hidden, trackable, pair
        ((0.04, 0.0, 0.04), (True, False, False)),
        ((0.05, 0.0, 0.0), (False, False, False)),
        ((0.25, 0.0, 0.25), (False, True, False)),
        ((0.25, 0.25, 0.0), (False, True, False)),
        ((0.2, 0.2, 1.0), (False, False, False)),
        ((0.5, 0.0, 0.5), (False, True, True)),
        ((1.0, 1.0, 0.4), (False, True, False)),
    ]
    flags = np.array(truth_flags(np.array([row for row, _ in table]).T, cameras)).T
    assert [tuple(map(bool, v)) for v in flags] == [expected for _, expected in table]


@pytest.mark.parametrize("names", [("cam0", "cam2"), ("cam1", "cam3")])
def test_two_cameras_of_one_kind_are_enough_in_rooms_without_the_other(names):
    cameras = [ROOM.cameras[name] for name in names]
    shares = np.array([[1.0, 0.24], [0.25, 0.25], [0.5, 0.5]]).T
    flags = np.array(truth_flags(shares, cameras)).T
    assert flags.tolist() == [[False, False, False], [False, True, False], [False, True, True]]


def test_one_depth_camera_is_enough_to_track_a_target():
    cameras = [ROOM.cameras["cam1"], replace(ROOM.cameras["cam1"], kind="depth")]
    shares = np.array([[1.0, 0.24], [0.0, 0.25], [0.0, 0.5]]).T
    flags = np.array(truth_flags(shares, cameras)).T
    assert flags.tolist() == [[False, False, False], [False, True, False], [False, True, True]]


@pytest.mark.parametrize("plane", ["floor", "wall"])
def test_a_point_of_a_screen_is_looked_up_where_the_camera_sees_it(plane):
    camera = ROOM.cameras["cam0"]
    screens = screens_of([ROOM.planes[name].tolist() for name in ROOM.planes])
    number = list(ROOM.planes).index(plane)
    place, seen = lookup(camera, rays_of(camera), screens)
    screen = screens[number]
    points = screen.corner + np.array([[2.4, 2.0], [1.8, 1.6], [2.9, 1.5]]) @ screen.axes
    assert np.allclose(points @ ROOM.planes[plane][:3] + ROOM.planes[plane][3], 0)
    pixel = project(camera, points)
    inside = ((pixel > 1) & (pixel < np.array(camera.size) - 2)).all(axis=1)
    assert inside.sum() >= 2
    for point, (u, v) in zip(points[inside], np.round(pixel[inside]).astype(int), strict=True):
        assert seen[v, u] == number
        assert np.abs(place[v, u] - screen.texel(point)).max() < 3  # a pixel is up to 3 texels

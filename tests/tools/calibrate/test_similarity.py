"""Similarity transforms: exact for points and cameras, blind to points that were moved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.tools.calibrate.rooms import made_room

from followspot.geometry import project
from followspot_calibrate.adjust.projection import rotation_of
from followspot_calibrate.similarity import Similarity, agreeing, on_a_line, similarity

small = st.floats(-3, 3)
vectors = st.tuples(small, small, small).map(np.array)
transforms = st.builds(
    lambda turn, shift, scale: Similarity(rotation_of(turn), shift, scale),
    vectors,
    vectors,
    st.floats(0.1, 10),
)


@settings(deadline=None)
@given(transforms, st.integers(3, 8))
def test_a_similarity_is_recovered_from_its_points(true, count):
    points = np.random.default_rng(count).normal(size=(count, 3))
    found = similarity(points, true.points(points))
    assert found.scale == pytest.approx(true.scale)
    assert found.rotation == pytest.approx(true.rotation, abs=1e-7)
    assert found.points(points) == pytest.approx(true.points(points), abs=1e-7)


@settings(deadline=None)
@given(transforms)
def test_a_moved_camera_sees_the_moved_points_where_it_saw_them(transform):
    room = made_room(cameras=2, rows=10)
    camera = room.cameras[0]
    moved = transform.camera(camera)
    assert project(moved, transform.points(room.points)) == pytest.approx(project(camera, room.points))
    assert moved.center == pytest.approx(transform.points(camera.center[None])[0])


def test_a_mirrored_copy_is_turned_and_not_mirrored():
    points = np.random.default_rng(0).normal(size=(6, 3))
    found = similarity(points, points * [1, 1, -1])
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_without_scale_lengths_stay():
    points = np.random.default_rng(0).normal(size=(6, 3))
    assert similarity(points, 2 * points, scaled=False).scale == 1


def test_points_that_were_moved_do_not_agree():
    points = np.random.default_rng(0).normal(size=(7, 3))
    target = 3 * points + 1
    target[2] += [0.0, 2.0, 0.0]
    assert agreeing(points, target).tolist() == [i != 2 for i in range(7)]


def test_points_on_a_line_give_no_frame():
    line = np.outer(np.arange(5), [1.0, 2.0, 3.0])
    assert on_a_line(line)
    assert on_a_line(np.eye(3)[:2])
    assert not on_a_line(np.eye(3))
    with pytest.raises(ValueError, match="not on a line"):
        similarity(line, line)

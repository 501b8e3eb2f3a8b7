"""Too little depth: the focal length is not determined, and that is said where it had to be found."""

from __future__ import annotations

import numpy as np
import pytest
from tests.tools.calibrate.rooms import made_room, waved_room

from followspot_calibrate.wand.diagnosis import DEEP, depths, shallow
from followspot_calibrate.wand.diagnostics import depth_warnings, warnings_of
from followspot_calibrate.wand.rounds import RobustAdjustment
from followspot_calibrate.wand.solving import solve


def test_a_ratio_under_two_is_told_with_the_cameras():
    room = made_room(4, 300, noise=0.4)
    middle = np.abs(room.points - [0, 0, 1]).max(axis=1) < 0.8
    solved = solve(room.sightings.rows(middle), room.cameras, "known")
    ratios = shallow(solved.adjusted)
    assert set(ratios) == {"cam0", "cam1", "cam2", "cam3"}
    assert max(ratios.values()) < DEEP
    told = depth_warnings(solved.adjusted)[0]
    assert f"cam0 {ratios['cam0']:.1f}" in told
    assert "focal length is not well determined; wave nearer" in told


def test_known_lenses_need_no_depth():
    room = made_room(4, 300, noise=0.4)
    middle = np.abs(room.points - [0, 0, 1]).max(axis=1) < 0.8
    assert warnings_of(solve(room.sightings.rows(middle), room.cameras, "known")) == []


def test_the_focal_length_is_kept_where_the_depth_does_not_tell_it():
    room = waved_room(4, 300)
    middle = np.abs(room.points - [0, 0, 1]).max(axis=1) < 0.9
    solved = solve(room.sightings.rows(middle), room.cameras, "auto")
    found = [camera.matrix[0, 0] for camera in solved.adjusted.cameras]
    assert found == [camera.matrix[0, 0] for camera in room.cameras]


def test_depth_is_the_farthest_over_the_nearest():
    cameras = made_room(3, 1).cameras
    along = np.linspace(1.0, 3.0, 101)[:, None]
    points = cameras[0].center + along * cameras[0].rotation[2]
    used = np.ones((101, 3), bool)
    adjusted = RobustAdjustment(cameras, points, used, np.zeros((101, 3, 2)), 0.4)
    assert depths(adjusted, 0) == pytest.approx((1.04, 2.96), abs=0.01)
    assert "cam0" not in shallow(adjusted)

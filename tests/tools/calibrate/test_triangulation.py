"""Points of the room from sightings, some of which are wrong."""

import numpy as np
import pytest
from tests.tools.calibrate.rooms import made_room

from followspot_calibrate.triangulation import leave_one_out, triangulate


@pytest.mark.parametrize("cameras", [2, 3, 8])
def test_exact_sightings_give_the_exact_points(cameras: int) -> None:
    room = made_room(cameras, 60)
    found = triangulate(room.cameras, room.sightings.pixel)
    known = room.sightings.seen.sum(axis=1) >= 2
    np.testing.assert_allclose(found.points[known], room.points[known], atol=1e-7)
    assert np.isnan(found.points[~known]).all()
    assert (found.used[known] == room.sightings.seen[known]).all()
    assert not found.used[~known].any()


def test_gross_outliers_do_not_spoil_points_that_three_views_agree_on() -> None:
    room = made_room(6, 300, outliers=0.15, noise=0.2, missing=0.1)
    found = triangulate(room.cameras, room.sightings.pixel)
    good = (room.sightings.seen & ~room.outlier).sum(axis=1) >= 3
    off = np.linalg.norm(found.points[good] - room.points[good], axis=1)
    assert np.median(off) < 0.003
    assert (off < 0.02).mean() > 0.99
    assert (found.used & room.outlier).sum() < 0.03 * room.outlier.sum()


def test_residuals_of_outliers_are_told_though_they_are_not_used() -> None:
    room = made_room(5, 50, outliers=0.1)
    found = triangulate(room.cameras, room.sightings.pixel)
    out = room.outlier & ~found.used & np.isfinite(found.points[:, :1])
    assert out.any()
    assert (np.linalg.norm(found.residual[out], axis=1) > 6.4).all()


def test_a_camera_left_out_cannot_pull_the_point_towards_itself() -> None:
    room = made_room(4, 80)
    pixel = room.sightings.pixel.copy()
    pixel[:, 2] += [3.0, -1.0]
    found = triangulate(room.cameras, pixel)
    alone = leave_one_out(room.cameras, pixel, found)[:, 2]
    others = (room.sightings.seen & (np.arange(4) != 2)).sum(axis=1) >= 2
    pulled = found.residual[others & room.sightings.seen[:, 2], 2]
    exact = np.abs(alone - [3.0, -1.0]).max(axis=1) < 1e-6
    assert exact[others & room.sightings.seen[:, 2]].mean() > 0.9
    assert np.nanmedian(np.linalg.norm(pulled, axis=1)) < np.hypot(3, 1)


def test_a_point_that_one_camera_sees_is_unknown() -> None:
    room = made_room(3, 10)
    pixel = room.sightings.pixel.copy()
    pixel[0, 1:] = np.nan
    found = triangulate(room.cameras, pixel)
    assert np.isnan(found.points[0]).all()
    assert not found.used[0].any()

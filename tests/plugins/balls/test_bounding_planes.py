"""A ball does not sink into a plane: positions below are corrected along what their covariance says."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import Array, Room
from followspot.tracking import Positions
from followspot_balls.scene.bounding_planes import facing_planes, raised

FLOOR, WALL = [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 2.0]
RADIUS, SIGMA = 0.07, 0.004


def positions(xyz: Array, covariance: Array) -> Positions:
    """One position of target 1, from two pairs."""
    return Positions(
        target=np.array([1], np.int32),
        xyz=xyz[None],
        covariance=covariance[None],
        support=np.array([2], np.int32),
        confirmed=np.ones(1, bool),
        evident=np.ones(1, bool),
        iterations=np.ones(1, np.int32),
        predicted=np.zeros(1, bool),
    )


def bounded(xyz: Array, covariance: Array, *planes: list[float]) -> tuple[Array, Array]:
    """What becomes of one position; target 0 is large, so that taking its radius would be noticed."""
    given = positions(xyz, covariance)
    found = raised(given, np.array(planes).reshape(-1, 4), np.array([0.5, RADIUS]), SIGMA)
    assert np.array_equal(given.xyz[0], xyz)
    return found.xyz[0], found.covariance[0]


@pytest.mark.parametrize(
    ("planes", "bounding"),
    [
        ({"floor": FLOOR, "wall": WALL}, [FLOOR, WALL]),
        ({"floor": [0.0, 0.0, -1.0, 0.0]}, [FLOOR]),
        ({"table": [0.0, 0.0, 1.0, -0.75], "floor": FLOOR}, [FLOOR]),
        ({"raked stage": [0.17, 0.0, 0.985, -0.5], "floor": FLOOR}, [FLOOR]),
        ({"between the cameras": [1.0, 0.0, 0.0, 0.0], "floor": FLOOR}, [FLOOR]),
        ({}, []),
    ],
)
def test_what_all_cameras_are_on_one_side_of_bounds_the_room_unless_a_plane_lies_behind(
    planes: dict[str, list[float]], bounding: list[list[float]]
) -> None:
    centers = np.array([[1.5, 0.0, 2.5], [-1.5, 0.0, 2.5], [0.0, 1.5, 3.0]])
    room = Room("r", {}, planes={name: np.array(plane) for name, plane in planes.items()})
    assert facing_planes(room, centers).tolist() == bounding


def test_a_sunken_position_is_the_most_probable_one_given_that_it_touches_the_plane() -> None:
    side = np.random.default_rng(3).normal(size=(3, 3)) * 0.01
    covariance, xyz = side @ side.T, np.array([0.3, -0.2, RADIUS - 0.02])
    found, left = bounded(xyz, covariance, FLOOR)
    normal = np.array(FLOOR[:3])
    information = np.linalg.inv(covariance) + np.outer(normal, normal) / SIGMA**2
    right = np.linalg.inv(covariance) @ xyz + normal * RADIUS / SIGMA**2
    assert found == pytest.approx(np.linalg.solve(information, right), abs=1e-12)
    assert left == pytest.approx(np.linalg.inv(information), abs=1e-12)


@pytest.mark.parametrize("planes", [[FLOOR], []])
def test_a_position_above_all_planes_stays(planes: list[list[float]]) -> None:
    xyz, covariance = np.array([0.3, -0.2, RADIUS + 0.001]), np.eye(3) * 1e-4
    found, left = bounded(xyz, covariance, *planes)
    assert np.array_equal(found, xyz)
    assert np.array_equal(left, covariance)


def test_the_plane_that_a_ball_sinks_into_most_corrects_it() -> None:
    xyz = np.array([-2 + RADIUS - 0.01, 0.0, RADIUS - 0.03])
    found, _ = bounded(xyz, np.eye(3) * 1e-4, WALL, FLOOR)
    assert found[0] == xyz[0]
    assert found[2] > xyz[2] + 0.02


def test_an_error_that_came_along_a_ray_is_corrected_along_the_ray() -> None:
    along = np.array([0.6, 0.0, 0.8])
    xyz = np.array([1.0, 1.0, RADIUS]) - 0.02 * along
    found, _ = bounded(xyz, np.outer(along, along) * 0.02**2 + np.eye(3) * 1e-8, FLOOR)
    assert np.linalg.norm(found - [1.0, 1.0, RADIUS]) < 0.002


def test_a_position_without_covariance_stays() -> None:
    xyz = np.array([0.0, 0.0, 0.0])
    found, _ = bounded(xyz, np.full((3, 3), np.nan), FLOOR)
    assert np.array_equal(found, xyz)

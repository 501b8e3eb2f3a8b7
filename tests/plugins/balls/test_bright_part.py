"""The share of a ball's outline that infrared blobs fill, learnt from templates of cameras anywhere."""

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, look_at

from followspot.messages import Array
from followspot.room import Camera, Room, Target
from followspot_balls.measurement.bright_part import bright_part, distances_to_middle
from followspot_balls.measurement.outline import unit_outline

MIDDLE = np.array([0.0, 0.0, 1.0])
REACH = 0.9
"""How far before and behind the middle the balls of the templates were, m."""
PLACES = {
    "near": ("infrared", (1.5, 0.0, 2.0)),
    "far": ("infrared", (0.0, 4.0, 3.0)),
    "left": ("color", (-2.0, 0.5, 2.5)),
    "right": ("color", (0.5, -3.5, 3.0)),
}


def cameras_there() -> list[Camera]:
    return [look_at(name, kind, place) for name, (kind, place) in PLACES.items()]


def outline(camera: Camera, away: float, radius: float = RADIUS) -> float:
    return float(np.pi * (camera.matrix[0, 0] * radius / away) ** 2)


def learnt(cameras: list[Camera], part: dict[str, float], away: Array | None = None) -> Room:
    """A room whose templates are of balls of which each kind of camera shows a part."""
    if away is None:
        away = np.array([np.linalg.norm(c.center - MIDDLE) for c in cameras])
    targets = {}
    for name, radius in (("red", RADIUS), ("green", 2 * RADIUS)):
        areas = {
            c.name: tuple(part[c.kind] * outline(c, d + side, radius) for side in (REACH, -REACH))
            for c, d in zip(cameras, away, strict=True)
        }
        targets[name] = Target(name, radius, area=areas)
    return Room("test", {c.name: c for c in cameras}, targets=targets)


@pytest.mark.parametrize("part", [0.5, 1.0, 1.2])
def test_all_infrared_cameras_show_one_part_of_a_ball_however_far_they_are(part: float) -> None:
    room = learnt(cameras_there(), {"infrared": part, "color": 1.0})
    np.testing.assert_allclose(bright_part(room), [part, part, 1, 1], rtol=1e-6)


def test_the_expected_area_is_that_of_whole_balls_in_near_and_far_cameras() -> None:
    cameras = cameras_there()
    room = learnt(cameras, {"infrared": 0.7, "color": 1.0})
    expected = unit_outline(room) * RADIUS**2 / 2.0**2
    np.testing.assert_allclose(expected[:2], [0.7 * outline(c, 2.0) for c in cameras[:2]], rtol=1e-6)
    np.testing.assert_allclose(expected[2:], [outline(c, 2.0) for c in cameras[2:]], rtol=1e-6)


def test_colors_that_show_smaller_than_the_ball_make_no_part_of_a_color_camera() -> None:
    room = learnt(cameras_there(), {"infrared": 0.9, "color": 0.9})
    np.testing.assert_allclose(bright_part(room), 1, rtol=1e-6)


def test_one_camera_with_an_odd_template_counts_as_one_of_its_kind() -> None:
    room = learnt(cameras_there(), {"infrared": 0.8, "color": 1.0})
    doubled = {
        name: replace(t, area={**t.area, "far": tuple(2 * a for a in t.area["far"])})
        for name, t in room.targets.items()
    }
    part = bright_part(replace(room, targets=doubled))
    np.testing.assert_allclose(part[:2], 0.8 * np.sqrt(2), rtol=1e-6)


def test_cameras_of_one_kind_and_templates_that_are_missing_say_nothing() -> None:
    alone = [c for c in cameras_there() if c.kind == "infrared"]
    np.testing.assert_array_equal(bright_part(learnt(alone, {"infrared": 0.5})), 1)
    room = learnt(cameras_there(), {"infrared": 0.5, "color": 1.0})
    no_areas = {name: replace(t, area={}) for name, t in room.targets.items()}
    np.testing.assert_array_equal(bright_part(replace(room, targets=no_areas)), 1)
    empty = {
        name: replace(t, area={**t.area, "near": (0.0, 0.0), "far": (0.0, 9.0)})
        for name, t in room.targets.items()
    }
    np.testing.assert_array_equal(bright_part(replace(room, targets=empty)), 1)


def test_a_camera_without_a_template_has_the_part_of_its_kind() -> None:
    room = learnt(cameras_there(), {"infrared": 0.6, "color": 1.0})
    partly = {
        name: replace(t, area={k: v for k, v in t.area.items() if k != "far"})
        for name, t in room.targets.items()
    }
    np.testing.assert_allclose(bright_part(replace(room, targets=partly)), [0.6, 0.6, 1, 1], rtol=1e-6)


def test_the_middle_is_where_the_optical_axes_meet() -> None:
    cameras = cameras_there()
    expected = [np.linalg.norm(c.center - MIDDLE) for c in cameras]
    np.testing.assert_allclose(distances_to_middle(cameras), expected, rtol=1e-6)


def test_axes_that_meet_nowhere_before_the_cameras_tell_no_distance() -> None:
    cameras = cameras_there()
    ahead = cameras[0].rotation
    parallel = [replace(c, rotation=ahead, translation=-ahead @ c.center) for c in cameras]
    np.testing.assert_array_equal(distances_to_middle(parallel), 1)
    turn = np.diag([-1.0, 1.0, -1.0])  # to look outwards
    outwards = [
        replace(c, rotation=turn @ c.rotation, translation=-turn @ c.rotation @ c.center) for c in cameras
    ]
    np.testing.assert_array_equal(distances_to_middle(outwards), 1)
    np.testing.assert_array_equal(distances_to_middle(cameras[:1]), 1)
    room = learnt(parallel, {"infrared": 0.5, "color": 1.0}, away=np.full(4, 3.0))
    np.testing.assert_allclose(bright_part(room), [0.5, 0.5, 1, 1], rtol=1e-6)

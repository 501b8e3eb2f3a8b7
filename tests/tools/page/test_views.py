"""Messages as the page draws them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from followspot.graph.compile import compile_graph
from followspot.messages import Header, stamped
from followspot.people import Poses
from followspot.room import Camera, Room
from followspot_page.scene import bounds
from followspot_page.views import view


def looking_along_x(model: Literal["pinhole", "cylinder"] = "pinhole") -> Camera:
    """At the origin, 1.5 m high; right in the picture is -y."""
    rotation = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    size = (1257, 240) if model == "cylinder" else (320, 240)
    matrix = np.array([[200.0, 0.0, size[0] / 2], [0.0, 200.0, 120.0], [0.0, 0.0, 1.0]])
    translation = -rotation @ np.array([0.0, 0.0, 1.5])
    none = np.zeros(0 if model == "cylinder" else 5)
    return Camera("cam", "color", size, matrix, none, rotation, translation, model)


def poses(x: float, heading: float, pan: float = 0.0, tilt: float = 0.0) -> Poses:
    """One person 1.8 m tall on the axis of the camera."""
    one = np.ones(1)
    found = Poses(
        "", one.astype("i4"), one.astype("u1"), np.array([[x, 0.0]]), 1.8 * one,
        heading * one, pan * one, tilt * one, np.full((1, 6), 0.1), one,
    )  # fmt: skip
    return stamped(found, Header("camera", 0, 0))


def test_arrows_in_a_picture_point_where_chest_and_face_do() -> None:
    room = Room(cameras={"cam": looking_along_x()})
    told = view(poses(3.0, heading=math.pi / 2, pan=math.pi / 2, tilt=0.5), room)
    ((head, gaze, chest, front),) = told["arrows"]["cam"]
    assert front[0] < chest[0] - 10  # its left, as +y is
    assert front[1] == pytest.approx(chest[1], abs=0.5)
    assert gaze[0] == pytest.approx(head[0], abs=0.5)  # a quarter further to its left: towards the camera
    assert gaze[1] < head[1] - 5  # and up
    x, y, radius = told["images"]["cam"][0]
    assert (x, y) == (head[0], head[1])
    assert radius == pytest.approx(200 * 0.115 / 3.0, rel=0.05)
    json.dumps(told)


@pytest.mark.parametrize(("model", "x"), [("pinhole", -3.0), ("cylinder", -3.0)])
def test_no_arrow_is_drawn_of_who_is_not_in_the_picture_or_stands_at_its_seam(
    model: Literal["pinhole", "cylinder"], x: float
) -> None:
    room = Room(cameras={"cam": looking_along_x(model)})
    assert view(poses(x, heading=math.pi / 2), room)["arrows"]["cam"] == [None]


def test_the_floor_around_a_panorama_is_shown_on_all_sides() -> None:
    camera = looking_along_x("cylinder")
    low, high = bounds(Room(cameras={"cam": camera}))
    assert (low[:2] < -1).all()
    assert (high[:2] > 1).all()


def test_where_no_number_is_known_the_page_is_told_nothing() -> None:
    room = compile_graph(Path(__file__).parents[3] / "graphs" / "glowballs.yaml").room
    told = view(poses(1.0, heading=math.nan), room)
    assert told["heading"] == [None]
    assert json.dumps(told, allow_nan=False)

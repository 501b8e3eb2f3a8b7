"""Messages as the page draws them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from tests.stages.sensors import Pressure, posed, resting
from tests.tools.page.served import tracks

from followspot.graph.compile import compile_graph
from followspot.inertial import Inertial
from followspot.messages import Array, Header, Message, column, stamped
from followspot.people import Poses, Skeletons
from followspot.room import Camera, Room
from followspot_page.display.message_views import view
from followspot_page.display.scene import bounds


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


def test_bones_join_the_joints_of_one_person_in_the_room_and_in_each_picture() -> None:
    names = ("left_hip", "left_knee", "left_ankle", "nose")
    leg = np.array([[3.0, 0.5, 1.0], [3.0, 0.5, 0.6], [-3.0, 0.5, 0.2], [3.0, 0.0, 1.7]])
    skeletons = Skeletons(
        labels=names,
        person=np.array([4, 4, 4, 5], np.int32),
        label=np.arange(4, dtype=np.int32),
        xyz=leg,
        covariance=np.zeros((4, 3, 3)),
        views=np.full(4, 2, np.int32),
    )
    told = view(stamped(skeletons, Header("people", 0, 0)), Room(cameras={"cam": looking_along_x()}))
    assert told["person"] == [4, 4]
    assert told["bones"] == [leg[:2].tolist(), leg[1:3].tolist()]
    thigh, shin = told["images"]["cam"]
    assert thigh[0][0] == pytest.approx(thigh[1][0])
    assert thigh[0][0] < 160  # to the left, as +y is, and downwards
    assert thigh[1][1] - thigh[0][1] == pytest.approx(200 * 0.4 / 3.0, abs=0.1)
    assert shin is None  # one end is behind the camera
    json.dumps(told)


def test_where_no_number_is_known_the_page_is_told_nothing() -> None:
    room = compile_graph(Path(__file__).parents[3] / "graphs" / "glowballs.yaml").room
    told = view(poses(1.0, heading=math.nan), room)
    assert told["heading"] == [None]
    assert json.dumps(told, allow_nan=False)


def test_posed_tracks_are_told_as_tracks_with_their_quaternions() -> None:
    room = Room()
    turned = np.array([[math.sqrt(0.5), 0, 0, math.sqrt(0.5)], [math.nan] * 4])
    told = view(posed(tracks(1, 3), turned), room)
    assert told["kind"] == "Tracks"
    assert told["quaternion"] == [[0.7071, 0.0, 0.0, 0.7071], [None] * 4]
    assert told["sigma"][0] == [0.005, 0.0025, 0.01]
    assert view(tracks(1), room)["quaternion"] == []


def test_of_many_inertial_readings_some_at_equal_steps_are_drawn_with_the_last() -> None:
    time = np.arange(1000) * 1_000_000
    turning = np.full((1000, 3), math.nan)
    turning[-1] = 0.5
    told = view(Inertial("wrist", time, turning, np.ones((1000, 3)), turning), Room())
    assert (told["kind"], told["readings"], len(told["times"])) == ("Inertial", 1000, 16)
    assert (told["times"][0], told["times"][-1], told["rate"]) == (0.0, 999.0, 1000.0)
    assert (told["turn_rate"][0], told["turn_rate"][-1]) == ([None] * 3, [0.5] * 3)
    assert json.dumps(told, allow_nan=False)
    assert view(resting(10**9), Room())["times"] == [910.0 + 10 * n for n in range(10)]
    none = view(Inertial.empty(), Room())
    assert (none["times"], none["rate"]) == ([], None)
    few = view(resting(10**9).where(slice(-2, None)), Room())
    assert (len(few["times"]), few["rate"]) == (2, None)


class Cloud(Message):
    """Many rows, a list in each."""

    beams: tuple[str, ...]
    place: Array = column("N", 3, unit="m", names="x y z")
    echoes: Array = column("N", "E")


def test_a_message_of_any_type_is_told_as_a_short_table() -> None:
    told = view(Pressure("well", np.array([1.25, math.nan])), Room())
    assert (told["kind"], told["message"], told["readings"]) == ("Message", "Pressure", 2)
    assert told["head"] == ["status", "height, m"]
    assert told["rows"] == [["well", "1.25"], ["well", "–"]]
    place = np.arange(300_000.0).reshape(-1, 3)
    long = view(Cloud(("a", "b"), place, np.zeros((100_000, 500))), Room())
    assert (long["readings"], len(long["rows"]), long["rows"][-1][1]) == (100_000, 6, "3e+05")
    assert len(json.dumps(long)) < 2000

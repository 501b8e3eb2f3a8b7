"""Figures of messages that browsers plot: which there are, their values, and their limits."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tests.tools.page.served import at, tracks

from followspot import Message, column
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot.people import Poses
from followspot.room import Room, Target
from followspot.tracking import Blobs, Frame, Tracks
from followspot_page.allowed_requests import MOST_CURVES, Curve, Plot, request_of
from followspot_page.display.curves import MOST_PORTS, ROWS, Curves, figures, values_of
from followspot_page.display.feed import Feed

ROOM = Room(targets={"red": Target("red", 0.05), "blue": Target("blue", 0.05)})
PORT = "track.tracks"


class Gain(Message):
    gain: float
    name: str
    steps: Array = column("K", dtype="i8")


class Setting(Message):
    gain: float


def curve(field: str, row: str = "", port: str = PORT) -> Curve:
    return Curve(port, row, field)


def test_every_number_of_every_port_is_offered_but_no_pictures_and_no_names() -> None:
    found = figures({PORT: Tracks, "camera/cam0.out": Frame, "set.out": Setting, "color.out": Blobs}, ROOM)
    assert set(found["ports"]) == {PORT, "set.out", "color.out"}
    of_tracks = found["kinds"][found["ports"][PORT]]
    assert of_tracks["rows"] == "target"
    assert {"name": "z", "unit": "m"} in of_tracks["fields"]
    assert {"name": "vx", "unit": "m/s"} in of_tracks["fields"]
    assert not {"object", "state"} & {field["name"] for field in of_tracks["fields"]}
    setting = found["kinds"][found["ports"]["set.out"]]
    assert setting == {"fields": [{"name": "gain", "unit": ""}], "rows": ""}
    json.dumps(found)


def test_a_value_is_found_by_its_row_and_field() -> None:
    message = tracks(1, 3)
    wanted = [
        curve("z", "red"),
        curve("x", "blue"),
        curve("z", "green"),
        curve("nothing", "red"),
        curve(ROWS),
    ]
    assert values_of(message, wanted, ROOM) == [1.0, 0.5, None, None, 2.0]
    assert values_of(tracks(), [curve("z", "red"), curve(ROWS)], ROOM) == [None, 0.0]
    assert values_of(message, [curve("state", "red")], ROOM) == [None]  # a text


def test_rows_without_names_are_counted_and_what_is_no_number_is_nothing() -> None:
    gain = Gain(1.5, "a", np.array([4, 9]))
    assert values_of(gain, [curve("steps", "1"), curve("gain", "0"), curve("steps", "7")], ROOM) == [
        9,
        1.5,
        None,
    ]
    assert values_of(Setting(float("inf")), [curve("gain")], ROOM) == [None]
    assert values_of(Setting(2.0), [curve("gain")], ROOM) == [2.0]
    assert [field["name"] for field in figures({"p.out": Poses}, ROOM)["kinds"].popitem()[1]["fields"]]


def test_the_newest_values_of_chosen_figures_are_fed_and_no_others() -> None:
    feed, known = Feed(), {PORT, "color.out"}
    curves = Curves(feed, ROOM)
    curves.take(PORT, at(40, tracks(1)))
    assert feed.newest(f"curves {PORT}") is None
    one, other = object(), object()
    curves.choose(one, [curve("z", "red")], known)
    curves.choose(other, [curve("z", "red"), curve("x", "red")], known)
    curves.take(PORT, at(80, tracks(1)))
    told = json.loads(feed.newest(f"curves {PORT}") or "")
    assert (told["time"], told["values"]) == (80.0, [["red", "z", 1.0], ["red", "x", 0.5]])
    curves.leave(other)
    curves.leave(other)
    curves.take(PORT, at(120, tracks(1)))
    assert json.loads(feed.newest(f"curves {PORT}") or "")["values"] == [["red", "z", 1.0]]
    curves.choose(one, [], known)
    assert curves.ports == frozenset()
    assert (
        len(feed.things) == 1
    )  # one for each port, however many figures browsers choose one after the other


def test_ports_that_are_not_there_and_too_many_are_refused() -> None:
    curves = Curves(Feed(), ROOM)
    with pytest.raises(FollowspotError, match="no port other"):
        curves.choose("a", [curve("z", port="other.out")], {PORT})
    many = [f"stage{i}.out" for i in range(MOST_PORTS + 1)]
    for i, port in enumerate(many[:-1]):
        curves.choose(i, [curve("z", port=port)], many)
    with pytest.raises(FollowspotError, match="already"):
        curves.choose("one more", [curve("z", port=many[-1])], many)
    curves.choose(0, [curve("z", port=many[-1])], many)  # instead of another
    assert many[-1] in curves.ports


@pytest.mark.parametrize(
    "plot",
    [
        [{"port": "a.b", "row": "", "field": "z"}] * (MOST_CURVES + 1),
        [{"port": "a" * 201, "row": "", "field": "z"}],
        [{"port": "a.b", "row": 1, "field": "z"}],
        [{"port": "a.b", "row": ""}],
        {"port": "a.b", "row": "", "field": "z"},
        "a.b.z",
        [[]],
    ],
)
def test_a_wish_of_another_form_is_refused(plot: object) -> None:
    with pytest.raises(FollowspotError, match="nothing that can be asked for"):
        request_of(json.dumps({"plot": plot}))
    assert request_of('{"plot": []}') == Plot(())

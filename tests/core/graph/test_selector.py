"""Selectors name members of a room by set, property and tag, and can be narrowed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from followspot.errors import Mistake, Place
from followspot.graph.selector import Selector, intersection, ranks, read_selector, related, within
from followspot.room import Member, Room, Sensor, Target
from followspot.testing import tiny_room
from followspot.yaml.node import Node

HERE = Place("graph.yaml", 1, 1)


def selector(text: str) -> Selector:
    mistakes: list[Mistake] = []
    found = read_selector(Node(text, HERE, HERE), mistakes)
    assert not mistakes
    return found


def room() -> Room:
    """Cameras a, b in the hall, b and c on the stage, d in neither; a sensor on the stage; a target."""
    one = next(iter(tiny_room().cameras.values()))
    zones = {"a": ("hall",), "b": ("hall", "stage"), "c": ("stage",), "d": ()}
    cameras = {
        name: replace(one, name=name, tags={"zone": zone, "rig": ("r1",)} if zone else {})
        for name, zone in zones.items()
    }
    cameras["c"] = replace(cameras["c"], kind="infrared")
    ball = Target("ball", 0.1, tags={"team": ("red",)})
    imu = Sensor("imu", "imu", rate=1000.0, host="pc", tags={"zone": ("attic",), "body": ("left",)})
    return Room("r", cameras, {}, {"ball": ball}, sensors={"imu": imu})


def names(text: str) -> list[str]:
    return [member.name for member in selector(text).select(room())]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("cameras", ["a", "b", "c", "d"]),
        ("camera", ["a", "b", "c", "d"]),
        ("cameras[zone=hall]", ["a", "b"]),
        ("cameras[zone=hall|stage]", ["a", "b", "c"]),
        ("cameras[zone=hall, zone=stage]", ["b"]),
        ("cameras[kind=color, zone=stage]", ["b"]),
        ("cameras[name=d|a]", ["a", "d"]),
        ("sensors", ["imu"]),
        ("sensors[kind=imu, host=pc]", ["imu"]),
        ("sensors[host=other]", []),
        ("targets[team=red]", ["ball"]),
        ("zones", ["hall", "stage", "attic"]),
        ("zone", ["hall", "stage", "attic"]),
        ("zones[name=stage]", ["stage"]),
        ("zones[zone=hall|attic]", ["hall", "attic"]),
        ("zones[kind=infrared]", ["stage"]),
        ("rigs", ["r1"]),
        ("bodies", ["left"]),
        ("cameras[model=fisheye]", []),
        ("cameras[zone=attic]", []),
    ],
)
def test_members_in_the_order_of_the_room(text: str, found: list[str]) -> None:
    assert names(text) == found
    assert selector(text).unknown(room()) is None


@pytest.mark.parametrize(
    ("text", "remedy"),
    [("cameras[zon=hall]", '"zone"'), ("zoness", '"zones"'), ("targets[kind=x]", "name"), ("teams", "zones")],
)
def test_a_word_that_the_room_does_not_know_is_told(text: str, remedy: str) -> None:
    mistake = selector(text).unknown(room())
    assert mistake is not None
    assert remedy in mistake.remedy
    assert not selector(text).select(room())


@pytest.mark.parametrize(
    ("first", "second", "both"),
    [
        ("cameras", "cameras[zone=hall]", "cameras[zone=hall]"),
        ("cameras[kind=color|infrared]", "cameras[kind=color, zone=hall]", "cameras[kind=color, zone=hall]"),
        ("cameras[kind=color]", "cameras[kind=infrared]", "cameras[kind=color, kind=infrared]"),
        ("cameras[zone=hall|stage]", "cameras[zone=stage]", "cameras[zone=hall|stage, zone=stage]"),
        ("cameras[zone=hall]", "cameras[zone=hall]", "cameras[zone=hall]"),
    ],
)
def test_an_intersection_selects_what_both_do_and_can_be_written(first: str, second: str, both: str) -> None:
    found = intersection(selector(first), selector(second))
    assert found.text == both
    in_both = [name for name in names(first) if name in names(second)]
    assert [m.name for m in found.select(room())] == names(found.text) == in_both


def test_sets_that_differ_have_no_intersection() -> None:
    with pytest.raises(ValueError, match="different sets"):
        intersection(selector("cameras"), selector("sensors"))


@pytest.mark.parametrize(
    ("text", "member", "part"),
    [
        ("cameras[kind=color]", Member("zone", "hall"), "cameras[kind=color, zone=hall]"),
        ("sensors", Member("zone", "attic"), "sensors[zone=attic]"),
        ("cameras", Member("cameras", "b"), "cameras[name=b]"),
        ("sensors", Member("cameras", "b"), "sensors"),
        ("targets", Member("zone", "hall"), "targets"),
        ("rigs", Member("zone", "hall"), "rigs[zone=hall]"),
    ],
)
def test_the_part_of_a_selector_within_a_member(text: str, member: Member, part: str) -> None:
    assert within(selector(text), member).text == part


def test_members_are_related_by_tags() -> None:
    made = room()
    hall, stage = Member("zone", "hall"), Member("zone", "stage")
    assert related(made, hall, "cameras") == (Member("cameras", "a"), Member("cameras", "b"))
    assert related(made, Member("cameras", "b"), "zone") == (hall, stage)
    assert related(made, hall, "zone") == (hall,)
    assert related(made, Member("cameras", "d"), "zone") == ()
    assert related(made, Member("sensors", "imu"), "cameras") is None
    assert related(made, hall, "targets") is None, "no target carries a zone, so all belong to each"
    assert related(made, Member("targets", "ball"), "zone") is None
    assert related(made, Member("body", "left"), "cameras") is None
    assert related(made, Member("body", "left"), "zone") is None
    assert list(ranks(made))[:6] == [
        *(Member("cameras", name) for name in "abcd"),
        Member("sensors", "imu"),
        Member("targets", "ball"),
    ]

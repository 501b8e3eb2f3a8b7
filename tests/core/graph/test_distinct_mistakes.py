"""A mistake inside a sub-graph that fans out is told once, not once for each member; so is a warning."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import planned
from tests.core.graph.files import ROOM

from followspot.errors import InputError, Mistake, Place
from followspot.graph.distinct_mistakes import distinct_mistakes

MAIN = """\
graph: main
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  one:  {graph: one.yaml, each: cameras, in: {frames: eyes}}
  pair: {uses: toy.pair, in: {blobs: one.blobs}}
"""
TWICE = """\
graph: main
room: room.yaml
stages:
  eyes:  {uses: room.source, each: cameras}
  left:  {graph: one.yaml, in: {frames: eyes}}
  right: {graph: one.yaml, in: {frames: eyes}}
  pair:  {uses: toy.pair, in: {blobs: [left.blobs, right.blobs]}}
"""
ONE = """\
graph: one
params:  {level: detect.level}
inputs:  {frames: camera}
outputs: {blobs: detect}
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}
"""
CAM2 = "  cam2:" + ROOM.split("  cam0:")[1].split("  cam1:")[0]
LATE = "{uses: toy.pair, in: {blobs: [detect, late]}}"


def refused(folder: Path, main: str, one: str, room: str = ROOM) -> list[str]:
    with pytest.raises(InputError) as caught:
        planned(folder, main, one=one, room=room)
    return [mistake.text for mistake in caught.value.mistakes]


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        ("in: {frame: camera}", "with: {lvl: 1}, in: {frame: camera}",
         'stage "one/cam0/detect" (toy.detect) has no parameter "lvl"'),
        ("in: {frame: camera}", "", 'stage "one/cam0/detect" (toy.detect) needs the input "frame"'),
        ("in: {frame: camera}", "in: {frames: camera}", 'stage "one/cam0/detect" has no input "frames"'),
        ("frame: camera}", "frame: kamera}", 'there is no stage "one/cam0/kamera"'),
        ("{blobs: detect}", "{found: detect}", 'sub-graph "one/cam0" has no output "blobs"'),
        ("inputs:  {frames", "inputs:  {pictures", 'graph "one", used as "one/cam0", has no input "frames"'),
        ("toy.detect, each: cameras", "toy.detect, each: 'cameras[kind=depth]'",
         'stage "one/cam0/detect" needs a camera that the room "stage" lacks'),
        ("outputs: {blobs: detect}", "outputs: {blobs: late}\n",
         "the stages one/cam0/late -> one/cam0/late wait for each other"),
    ],
)  # fmt: skip
def test_a_mistake_of_every_member_is_told_once(tmp_path: Path, before: str, after: str, text: str) -> None:
    one = ONE.replace(before, after)
    one += f"  late: {LATE}\n" if "late" in after else ""
    assert refused(tmp_path, MAIN, one) == [text]


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        ("in: {frame: camera}", "", 'stage "left/detect" (toy.detect) needs the input "frame"'),
        ("in: {frame: camera}", "in: {frames: camera}", 'stage "left/detect" has no input "frames"'),
        ("frame: camera}", "frame: kamera}", 'there is no stage "left/kamera"'),
        ("outputs: {blobs: detect}", "outputs: {blobs: late}\n",
         "the stages left/late -> left/late wait for each other"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_file_that_is_used_twice_is_told_once(
    tmp_path: Path, before: str, after: str, text: str
) -> None:
    one = ONE.replace(before, after)
    one += f"  late: {LATE}\n" if "late" in after else ""
    assert refused(tmp_path, TWICE, one) == [text]


def test_members_that_a_sender_does_not_serve_are_told_together(tmp_path: Path) -> None:
    main = MAIN + (
        "  few:  {uses: toy.any, each: 'cameras[name=cam1]', in: {blobs: one.blobs}}\n"
        "  more: {uses: toy.any, each: cameras, in: {blobs: few}}\n"
    )
    assert refused(tmp_path, main, ONE) == ['stage "more" serves camera cam0, stage "few" does not']
    room = ROOM.replace("  cam1:\n", CAM2 + "  cam1:\n")
    assert refused(tmp_path, main, ONE, room) == [
        'stage "more" serves camera cam0, camera cam2, stage "few" does not'
    ]


def test_a_warning_of_every_member_is_told_once(tmp_path: Path) -> None:
    plan = planned(tmp_path, MAIN, one=ONE + "  idle: {uses: toy.any, in: {blobs: detect}}\n")
    texts = [warning.text for warning in plan.warnings if "idle" in warning.text]
    assert texts == ['no stage reads what stage "one/cam0/idle" (toy.any) gives']


def test_different_mistakes_at_one_place_are_all_told() -> None:
    place = Place("one.yaml", 3, 1)
    found = [Mistake(place, text) for text in ('"a/b" needs x', '"a/c" needs x', '"a/b" needs y')]
    elsewhere = [
        Mistake(None, "a/b"),
        Mistake(None, "a/c"),
    ]
    used = Mistake(place.within(Place("main.yaml", 4, 1)), '"a/d" needs x')
    assert distinct_mistakes([*found, used, *elsewhere]) == [found[0], found[2], *elsewhere]


@pytest.mark.parametrize("feeds", ["[detect, detect]", "[detect, detect.out]"])
def test_an_input_that_is_fed_twice_from_one_output_is_refused(tmp_path: Path, feeds: str) -> None:
    one = ONE + f"  both: {{uses: toy.pair, in: {{blobs: {feeds}}}}}\n"
    (text,) = refused(tmp_path, MAIN, one)
    assert text.startswith('input "blobs" of stage "one/cam0/both" gets "one/cam0/detect')
    assert text.endswith(" twice")


def test_an_output_with_two_delays_feeds_an_input_twice(tmp_path: Path) -> None:
    one = ONE + "  both: {uses: toy.pair, in: {blobs: [detect, {from: detect, delay: 1}]}}\n"
    assert len([e for e in planned(tmp_path, MAIN, one=one).edges if "cam0/both" in e.to_stage]) == 2


def test_an_output_of_one_member_can_be_read(tmp_path: Path) -> None:
    main = MAIN + "  show: {uses: toy.any, in: {blobs: one/cam1.blobs}}\n"
    found = [edge.from_stage for edge in planned(tmp_path, main, one=ONE).edges if edge.to_stage == "show"]
    assert found == ["one/cam1/detect/cam1"]


@pytest.mark.parametrize("name", ["eyes/cam0", "one/cam1/detect/cam1"])
def test_an_option_for_one_instance_says_who_can_give_it(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError) as caught:
        planned(tmp_path, MAIN, f"{name}.level=0.5", one=ONE)
    (mistake,) = caught.value.mistakes
    group = name.rpartition("/")[0]
    assert (
        mistake.text
        == f'"{name}" is an instance of stage "{group}", and --set reaches all instances of a stage'
    )
    assert f"write {group}.level=VALUE" in mistake.remedy
    assert f"tune: {{{name}.level: VALUE}}" in mistake.remedy

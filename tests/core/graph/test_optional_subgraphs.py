"""A sub-graph that says `optional: true` is left out of a room that has nothing for it."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from tests.core.graph import composed, files
from tests.core.graph.composed import edges, names, write
from tests.core.graph.files import TOY

from followspot.cli.main import main
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data

ROOM = files.ROOM.replace("    host: pc-left\n", "")
ZONES = ROOM.replace("    kind: color\n", "    kind: color\n    tags: {zone: hall}\n").replace(
    "    kind: infrared\n", "    kind: infrared\n    tags: {zone: stage}\n"
)
MAIN = """\
graph: building
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  near: {graph: tracker.yaml, in: {frames: eyes}}
  far:  {graph: tracker.yaml, in: {frames: eyes}, WHICH}
  both: {uses: toy.pair, in: {blobs: [near.blobs, far.blobs]}}
"""


def planned(folder: Path, main: str, *overrides: str, room: str = ROOM, **more: str) -> Plan:
    return composed.planned(folder, main, *overrides, room=room, **more)


def planned_with(folder: Path, which: str, *overrides: str, room: str = ROOM, more: str = "") -> list[str]:
    plan = planned(folder, MAIN.replace("WHICH", which) + more, *overrides, room=room)
    assert not [name for name in names(plan) if name.startswith("far")]
    assert [edge for edge in edges(plan) if edge.endswith("both.blobs")] == [
        "near/detect/cam0.out -> both.blobs",
        "near/detect/cam1.out -> both.blobs",
    ]
    return list(plan.notes)


@pytest.mark.parametrize(
    ("which", "lacks"),
    [
        ("each: zones", "zones"),
        ("each: 'cameras[kind=thermal]'", "cameras[kind=thermal]"),
        ("cameras: 'cameras[zone=attic]'", "cameras[zone=attic]"),
        ("cameras: 'cameras[kind=thermal]', each: cameras", "cameras[kind=thermal]"),
    ],
)
def test_it_is_left_out_with_a_note_and_its_readers_go_on(tmp_path: Path, which: str, lacks: str) -> None:
    notes = planned_with(tmp_path, f"{which}, optional: true")
    assert notes == [f'sub-graph "far" is left out: the room has no {lacks}']


def test_it_is_there_in_a_room_that_has_what_it_asks_for(tmp_path: Path) -> None:
    plan = planned(tmp_path, MAIN.replace("WHICH", "each: zones, optional: true"), room=ZONES)
    assert {"far/hall/track", "far/stage/track"} <= {*names(plan)}
    assert plan.notes == ()


def test_a_member_without_cameras_is_left_out_alone(tmp_path: Path) -> None:
    which = "each: zones, cameras: 'cameras[kind=infrared]', optional: true"
    plan = planned(tmp_path, MAIN.replace("WHICH", which), room=ZONES)
    assert {name.split("/")[1] for name in names(plan) if name.startswith("far")} == {"stage"}
    assert plan.notes == (
        'sub-graph "far/hall" is left out: the room has no cameras[kind=infrared, zone=hall]',
    )


def test_a_part_of_it_that_is_named_from_outside_is_left_out_with_it(tmp_path: Path) -> None:
    more = "  late: {uses: toy.any, in: {blobs: near/pair, hint: far/track.tracks}}\n"
    planned_with(tmp_path, "each: zones, optional: true", "far/detect.level=0.7", more=more)


def test_what_needs_it_is_a_mistake_unless_that_is_optional_too(tmp_path: Path) -> None:
    more = "  last: {uses: toy.save, in: {tracks: far.tracks}}\n"
    with pytest.raises(InputError) as caught:
        planned_with(tmp_path, "each: zones, optional: true", more=more)
    (mistake,) = caught.value.mistakes
    assert mistake.text == 'input "tracks" of stage "last" needs what is left out'
    assert mistake.remedy.endswith('write optional: true for "last", too')
    assert mistake.place is not None
    assert [place.line for place in mistake.place.outer_places] == [6]
    more = more.replace("uses:", "optional: true, uses:")
    notes = planned_with(tmp_path, "each: zones, optional: true", more=more)
    assert notes[1:] == ['stage "last" is left out: so is all that feeds it']


def test_it_is_left_out_if_all_that_feeds_it_is(tmp_path: Path) -> None:
    main = MAIN.replace("in: {frames: eyes}, WHICH", "in: {frames: warm}, optional: true").replace(
        "  near:", "  warm: {uses: room.source, each: 'cameras[kind=thermal]', optional: true}\n  near:"
    )
    plan = planned(tmp_path, main)
    assert not [name for name in names(plan) if name.startswith("far")]
    assert plan.notes[1:] == ('sub-graph "far" is left out: so is all that feeds it',)


def test_of_a_sub_graph_within_one_that_is_left_out_nothing_is_told(tmp_path: Path) -> None:
    middle = "outputs: {blobs: inner.blobs}\ninputs: {frames: inner.frames}\n"
    middle += "stages:\n  inner: {graph: tracker.yaml, each: zones}\n"
    main = MAIN.replace("far:  {graph: tracker.yaml", "far:  {graph: middle.yaml")
    plan = planned(tmp_path, main.replace("WHICH", "each: zones, optional: true"), middle=middle)
    assert plan.notes == ('sub-graph "far" is left out: the room has no zones',)


def test_a_graph_of_which_nothing_is_left_says_why(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        planned(
            tmp_path, "room: room.yaml\nstages: {a: {graph: tracker.yaml, each: zones, optional: true}}\n"
        )
    (mistake,) = caught.value.mistakes
    assert mistake.text == ('nothing is left of the graph: sub-graph "a" is left out: the room has no zones')


@pytest.mark.parametrize("thermal", ["", "'cameras[kind=thermal]'"])
def test_the_flat_file_is_without_it(
    tmp_path: Path, thermal: str, capsys: pytest.CaptureFixture[str]
) -> None:
    main = MAIN.replace("WHICH", "each: zones, optional: true")
    main += "  last: {uses: toy.save, optional: true, in: {tracks: far.tracks}}\n"
    main += "  fine: {uses: toy.any, in: {blobs: both, hint: far.tracks}}\n"
    if thermal:
        warm = f"  warm: {{uses: room.source, each: {thermal}, optional: true}}\n  near:"
        main = main.replace("frames: eyes}, each: zones", "frames: warm}").replace("  near:", warm)
    plan = planned(tmp_path, main)
    assert main_flat(tmp_path, capsys) == plan_to_data(plan)["stages"]


def main_flat(folder: Path, capsys: pytest.CaptureFixture[str]) -> object:
    """The stages of the flat file of main.yaml, planned."""
    assert main(["graph", str(folder / "main.yaml"), "--flat", "--plugin", TOY]) == 0
    text = capsys.readouterr().out
    assert "far" not in str(yaml.safe_load(text)["stages"])
    (folder / "flat.yaml").write_text(text, encoding="utf-8")
    return plan_to_data(compile_graph(folder / "flat.yaml", plugin_files=[TOY]))["stages"]


def test_an_overlay_and_an_option_may_say_so(tmp_path: Path) -> None:
    assert planned_with(tmp_path, "each: zones", "far.optional=true")
    over = "extends: main.yaml\nstages: {far: {optional: true}}\n"
    write(tmp_path, main=MAIN.replace("WHICH", "each: zones"), over=over)
    assert compile_graph(tmp_path / "over.yaml", plugin_files=[TOY]).notes


def test_a_word_that_is_no_switch_is_one_mistake(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        planned(tmp_path, MAIN.replace("WHICH", "optional: maybe"))
    (mistake,) = caught.value.mistakes
    assert mistake.text == 'optional cannot be "maybe"'


NOTHING = ("", "")
TYPOS = composed.TRACKER.replace("toy.pair", "toy.piar").replace("{model: ", "{modle: 1, model: ")


@pytest.mark.parametrize(
    ("which", "tracker", "texts"),
    [
        ("each: zones", TYPOS, ['no stage "toy.piar" is installed',
         'stage "far/track" (toy.track) has no parameter "modle"']),
        ("cameras: 'cameras[zone=attic]'", TYPOS, ['no stage "toy.piar" is installed',
         'stage "far/track" (toy.track) has no parameter "modle"']),
        ("each: zones, with: {lvl: 1}", composed.TRACKER,
         ['graph "far", used as "far", has no parameter "lvl"']),
        ("each: zones, with: {level: high}", composed.TRACKER,
         ['"level" of stage "far/detect" (toy.detect) cannot be \'high\': it must be a number']),
    ],
)  # fmt: skip
def test_mistakes_in_it_are_told_although_it_is_left_out(
    tmp_path: Path, which: str, tracker: str, texts: list[str]
) -> None:
    main = MAIN.replace("WHICH", f"{which}, optional: true").replace(
        "far:  {graph: tracker", "far:  {graph: far"
    )
    far = tracker.replace("graph: tracker", "graph: far")
    with pytest.raises(InputError) as caught:
        planned(tmp_path, main, far=far)
    assert [mistake.text for mistake in caught.value.mistakes] == texts


@pytest.mark.parametrize(
    ("tracker", "main", "text"),
    [
        (("{blobs: detect}", "{blobs: track.forecast}"), NOTHING,
         '"far/track.forecast" gives Forecast, but input "blobs" of stage "far/pair" takes Blobs'),
        (NOTHING, ("far.blobs", "far.tracks"),
         '"far/track.tracks" gives Tracks, but input "blobs" of stage "both" takes Blobs'),
        (("hint: extra.hint", "hint: detect.forecast"),
         ("{frames: eyes}, each", "{frames: eyes, hint: near.tracks}, each"),
         '"near/track.tracks" gives Tracks, but input "forecast" of stage "far/detect" takes Forecast'),
        (("blobs: pair}", "blobs: {from: pair, tolerance: 1, delay: 1}}"), NOTHING,
         'input "blobs" of stage "far/extra" has a delay and matches no times'),
    ],
)  # fmt: skip
def test_types_in_it_are_checked_although_it_is_left_out(
    tmp_path: Path, tracker: tuple[str, str], main: tuple[str, str], text: str
) -> None:
    graph = MAIN.replace("WHICH", "each: zones, optional: true").replace(*main)
    graph = graph.replace("far:  {graph: tracker", "far:  {graph: far")
    assert tracker[0] in composed.TRACKER
    with pytest.raises(InputError) as caught:
        planned(tmp_path, graph, far=composed.TRACKER.replace(*tracker))
    (mistake,) = caught.value.mistakes
    assert text in mistake.text
    assert mistake.place is not None


def test_its_outputs_must_be_there_although_it_is_left_out(tmp_path: Path) -> None:
    main = MAIN.replace("WHICH", "each: zones, optional: true").replace("far.blobs", "far.blob")
    with pytest.raises(InputError, match='sub-graph "far" has no output "blob"'):
        planned(tmp_path, main)


def test_a_stage_that_is_left_out_is_checked(tmp_path: Path) -> None:
    late = "  late: {uses: toy.detect, each: zones, optional: true, in: {fram: eyes}, with: {lvl: 1}}\n"
    with pytest.raises(InputError) as caught:
        planned(tmp_path, MAIN.replace("WHICH", "each: zones, optional: true") + late)
    assert [mistake.text for mistake in caught.value.mistakes] == [
        'stage "late" has no input "fram"',
        'stage "late" (toy.detect) has no parameter "lvl"',
    ]

"""Graphs without mistakes that can never come to anything."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.core.graph.files import GRAPH, ROOM, TOY, write

import followspot as fs
from followspot.cli.main import main
from followspot.errors import Mistake
from followspot.graph.compile import compile_graph
from followspot.plugins.registry import load_stage

GRAPHS = Path(__file__).parents[3] / "graphs"
READY = sorted(GRAPHS.glob("*.yaml"))
SPARE = "  spare: {uses: toy.pair, in: {blobs: detect}}\n"


def warned(folder: Path, graph: str = GRAPH, room: str = ROOM) -> list[Mistake]:
    found = fs.check(write(folder, graph=graph, room=room), plugin_files=[TOY])
    assert all(mistake.warning for mistake in found), found
    return found


@pytest.mark.parametrize("file", [f for f in READY if "\nroom:" in f.read_text()], ids=lambda file: file.stem)
def test_the_ready_graphs_have_no_warnings_in_their_rooms(file: Path) -> None:
    assert compile_graph(file).warnings == ()


@pytest.mark.parametrize("room", sorted((GRAPHS / "rooms").glob("*.yaml")), ids=lambda room: room.stem)
def test_every_ready_room_is_whole_for_some_ready_graph(room: Path) -> None:
    assert any(not fs.check(file, room=room) for file in READY)


def test_a_stage_without_a_reader_is_named_at_its_place(tmp_path: Path) -> None:
    (mistake,) = warned(tmp_path, GRAPH + SPARE)
    assert mistake.text == 'no stage reads what stage "spare" (toy.pair) gives'
    assert mistake.place is not None
    assert mistake.place.line == GRAPH.count("\n") + 1


def test_what_an_interface_offers_needs_no_reader(tmp_path: Path) -> None:
    offered = GRAPH.replace("{tracks: track.tracks}", "{tracks: track.tracks, more: spare}")
    assert warned(tmp_path, offered + SPARE) == []


def test_cameras_that_are_opened_in_vain_are_named_together(tmp_path: Path) -> None:
    narrow = GRAPH.replace(
        "detect: {uses: toy.detect, each: cameras", 'detect: {uses: toy.detect, each: "cameras[kind=color]"'
    )
    (mistake,) = warned(tmp_path, narrow)
    assert mistake.text == 'no stage reads what stage "camera" gives for camera cam1 (infrared)'


def test_cameras_that_no_stage_serves_are_named_in_the_room_file(tmp_path: Path) -> None:
    narrow = GRAPH.replace("each: cameras", 'each: "cameras[kind=color]"')
    (mistake,) = warned(tmp_path, narrow)
    assert mistake.text == "no stage serves camera cam1 (infrared)"
    assert mistake.place is not None
    assert Path(mistake.place.file).name == "room.yaml"
    assert ROOM.splitlines()[mistake.place.line - 1].strip() == "cam1:"


def test_sensors_that_no_stage_serves_are_named_if_others_are_served(tmp_path: Path) -> None:
    sensors = "sensors:\n  wrist: {kind: imu}\n  ankle: {kind: imu}\n"
    assert warned(tmp_path, GRAPH, ROOM + sensors) == []
    one = '  lone: {uses: toy.imu, each: "sensors[name=wrist]"}\n'
    texts = [mistake.text for mistake in warned(tmp_path, GRAPH + one, ROOM + sensors)]
    assert "no stage serves sensor ankle (imu)" in texts


def test_a_stage_that_nothing_fires_is_named_and_those_after_it_are_not(tmp_path: Path) -> None:
    text = GRAPH + (
        "  idle: {uses: toy.any, in: {blobs: {from: next, delay: 1}}}\n"
        "  next: {uses: toy.any, in: {blobs: idle}}\n"
    )
    (mistake,) = warned(tmp_path, text)
    assert mistake.text == 'stage "idle" never fires: all its inputs are sampled or delayed'


RATES = """graph: rates
stages:
  fast:   {uses: rates.device, with: {hz: 1000}}
  slow:   {uses: rates.device, with: {hz: 100}}
  also:   {uses: rates.device, with: {hz: 120}}
  meet:   {uses: rates.meet, in: {frame: slow, reading: SENDER}}
  save:   {uses: rates.write, in: {readings: meet}}
"""


@pytest.mark.parametrize(
    ("sender", "share"), [("fast", "90%"), ("also", ""), ("{from: fast, delay: 1}", ""), ("slow", "")]
)
def test_a_join_of_streams_with_unequal_rates_is_named_with_what_it_leaves(
    tmp_path: Path, sender: str, share: str
) -> None:
    graph = write(tmp_path, graph=RATES.replace("SENDER", sender))
    found = fs.check(graph, plugin_files=[Path(TOY).parents[2] / "stages/rates.py"])
    named = [mistake for mistake in found if not mistake.text.startswith("no stage reads")]
    if not share:
        assert named == []
        return
    (mistake,) = named
    assert mistake.warning
    assert mistake.text.startswith('stage "meet" joins 1000 messages/s of stage "fast" with 100 of ')
    assert f"{share} find no partner" in mistake.text
    assert mistake.place is not None
    assert mistake.place.line == 6


def test_a_stage_whose_check_fails_is_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> list[Mistake]:
        raise ZeroDivisionError("oh")

    assert warned(tmp_path) == []
    monkeypatch.setattr(load_stage("toy.pair"), "check_room", broken)
    (mistake,) = warned(tmp_path)
    assert mistake.text == "toy.pair.check_room failed: ZeroDivisionError: oh"


def test_warnings_are_shown_by_check_and_by_run_and_are_no_mistakes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    graph = str(write(tmp_path, graph=GRAPH + SPARE))
    assert main(["check", graph, "--plugin", TOY]) == 0
    assert f"warning: {graph}:11:3: no stage reads" in capsys.readouterr().out
    assert main(["check", graph, "--plugin", TOY, "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["warnings"]
    assert (found["line"], found["column"]) == (11, 3)
    assert found["text"].startswith("no stage reads")


def test_a_warning_that_comes_before_a_mistake_is_not_shown(tmp_path: Path) -> None:
    wrong = (GRAPH + SPARE).replace("toy.track", "toy.trak")
    (mistake,) = fs.check(write(tmp_path, graph=wrong), plugin_files=[TOY])
    assert not mistake.warning

"""Sinks, exports and scripts take a message type that they have never seen."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.core.graph.composed import changed_stages

import followspot as fs
from followspot import Context, FollowspotError, Header, Room, Target
from followspot.cli.main import main
from followspot.graph.change.stages import with_stages
from followspot.graph.compile import compile_graph
from followspot.messages import stamped
from followspot.tracking import Forecast, Tracks
from followspot_sinks.csv_file import CsvFile
from followspot_sinks.osc import Osc

PLUGIN = """
import numpy as np
from followspot import Message, Source, Stage, at
from followspot.messages import Array, column
from followspot.tracking import Tracks

class Marker(Message):
    labels: tuple[str, ...]
    label: Array = column("N", dtype="i4", refers="labels")
    xyz: Array = column("N", 3, unit="m")
    quality: Array = column("N", names="how_good")

class Find(Stage):
    def process(self) -> Source[Marker]:
        for n in range(3):
            marker = np.arange(n, dtype="i4"), np.full((n, 3), 1 / 3), np.ones(n)
            yield at(n * 10_000_000, Marker(("left, or so", "right"), *marker))

class Track(Stage):
    def process(self) -> Source[Tracks]:
        for n in range(3):
            place = np.full((1, 3), 0.5)
            yield at(n * 10_000_000, Tracks(np.array([7], "i4"), np.ones(1, "u1"), place, place, place))
"""
"""A stranger's message type, and tracks of a marker with id 7 in a room without targets."""
GRAPH = """
graph: markers
stages:
  find: {uses: markers.find}
  track: {uses: markers.track}
  table: {uses: sinks.csv, in: {markers: find}, with: {path: markers.csv}}
  some: {uses: sinks.csv, in: {whatever: find}, with: {path: some.csv, columns: [x, label]}}
  lines: {uses: sinks.jsonl, in: {both: [find, track]}, with: {path: lines.jsonl}}
  show: {uses: sinks.console, in: {message: find}, with: {maximum_rate: 1000}}
  save: {uses: sinks.csv, in: {tracks: track}}
"""


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    (tmp_path / "markers.py").write_text(PLUGIN)
    (tmp_path / "markers.yaml").write_text(GRAPH)
    return tmp_path / "markers.yaml"


def test_every_sink_and_export_takes_any_type_with_names(
    graph: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = graph.parent / "out"
    show = graph.parent / "show.mcap"
    plugin = ["--plugin", str(graph.parent / "markers.py")]
    assert main(["run", str(graph), *plugin, "--out", str(out), "--quiet", "--record", str(show)]) == 0
    printed = capfd.readouterr().out
    assert "    0.010 s  left, or so  x +0.333  y +0.333  z +0.333  how_good +1.000\n" in printed
    third = repr(1 / 3)
    assert (out / "markers.csv").read_text().splitlines() == [
        "frame,time,label,x,y,z,how_good",
        f'1,0.010000000,"left, or so",{third},{third},{third},1.0',
        f'2,0.020000000,"left, or so",{third},{third},{third},1.0',
        f"2,0.020000000,right,{third},{third},{third},1.0",
    ]
    assert (out / "some.csv").read_text().splitlines()[-1] == f"2,0.020000000,{third},right"
    lines = [json.loads(line) for line in (out / "lines.jsonl").read_text().splitlines()]
    assert [line["type"] for line in lines] == ["Marker", "Tracks"] * 3
    assert lines[2]["rows"] == [{"label": "left, or so", "x": 1 / 3, "y": 1 / 3, "z": 1 / 3, "how_good": 1.0}]
    assert (out / "tracks.csv").read_text().splitlines()[1].startswith("0,0.000000000,7,tracked,0.500000,")
    assert main(["export", str(show), str(out), "--to", "csv"]) == 0
    with (out / "find.out.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["label"] for row in rows] == ["left, or so", "left, or so", "right"]
    with (out / "track.out.csv").open(newline="") as file:
        assert {row["object"] for row in csv.DictReader(file)} == {"7"}


def test_a_stage_of_one_type_refuses_two(graph: Path) -> None:
    graph.write_text(GRAPH.replace("{markers: find}", "{markers: [find, track]}"))
    with pytest.raises(fs.InputError, match="of one type, Marker and Tracks come"):
        compile_graph(graph, plugin_files=[graph.parent / "markers.py"])


def test_a_wrong_column_is_told_before_the_first_message(tmp_path: Path) -> None:
    sink = CsvFile(Context(out=tmp_path, receives=(Tracks,)), columns=["objekt"])
    with pytest.raises(fs.InputError, match=r'no column "objekt"\n *did you mean "object"'):
        sink.setup()
    sink.close()


def test_a_file_without_messages_has_its_head(tmp_path: Path) -> None:
    sink = CsvFile(Context(out=tmp_path, receives=(Tracks,)))
    sink.setup()
    sink.close()
    assert (tmp_path / "tracks.csv").read_text() == "frame,time,object,state,x,y,z,vx,vy,vz,sx,sy,sz\n"


def test_a_file_is_of_one_type(tmp_path: Path) -> None:
    sink = CsvFile(Context(out=tmp_path))
    sink.setup()
    sink.process((stamped(Tracks.empty(), Header("a", 0, 0)),))
    with pytest.raises(FollowspotError, match=r"tracks\.csv has other columns than Forecast"):
        sink.process((stamped(Forecast.empty(), Header("a", 0, 0)),))
    sink.close()


def test_a_script_feeds_a_sink_under_any_name(graph: Path) -> None:
    composed = fs.Graph("mine")
    composed.add("find", "markers.find")
    composed.add("save", "sinks.csv", markers=composed.port("find"), path="a.csv")
    entry = {"uses": "sinks.csv", "in": {"markers": "find"}, "with": {"path": "a.csv"}}
    assert composed.stages["save"] == entry


def test_a_sink_of_any_message_is_swapped_for_one_of_tracks_and_back() -> None:
    plan = compile_graph(Path(__file__).parents[3] / "graphs/glowballs.yaml")
    (osc,) = changed_stages(plan, ["save.uses=sinks.osc"])
    assert osc.uses == "sinks.osc"
    (back,) = changed_stages(with_stages(plan, [osc]), ["save.uses=sinks.csv"])
    assert back.uses == "sinks.csv"
    with pytest.raises(fs.InputError, match='has no input "tracks"'):
        changed_stages(plan, ["save.uses=sinks.osc_poses"])


COUNT = """
from followspot import Stage
from followspot.tracking import Tracks

class Count(Stage):
    def process(self, tracks: Tracks) -> None:
        with (self.context.out / "count.txt").open("a") as file:
            file.write(f"{tracks.header.seq}\\n")
"""


def test_sinks_swapped_in_a_run_miss_nothing_whatever_their_inputs_are_called(tmp_path: Path) -> None:
    """From a join of any messages to one input of tracks, and to another join."""
    (tmp_path / "count.py").write_text(COUNT)
    graph, out, frames = Path(__file__).parents[3] / "graphs/glowballs.yaml", tmp_path / "out", 90
    options: Any = {"frames": frames, "out": out, "plugin_files": [tmp_path / "count.py"]}
    with fs.run(graph, ports=["track.tracks"], **options) as run:
        for tracks in run["track.tracks"]:
            if tracks.header.seq == 1:
                run.swap("save", "count.count")
            if tracks.header.seq == 12:
                run.swap("save", "sinks.jsonl")
    rows = (out / "tracks.csv").read_text().splitlines()[1:]
    first = sorted({int(row.split(",")[0]) for row in rows})
    second = [int(line) for line in (out / "count.txt").read_text().splitlines()]
    third = [json.loads(line)["seq"] for line in (out / "messages.jsonl").read_text().splitlines()]
    assert first + second + third == list(range(frames))


def test_a_target_that_the_room_does_not_have_has_no_slot() -> None:
    """A track with index 7 in a room of one target ended a show with an IndexError."""
    sink = Osc(Context(room=Room(targets={"red": Target("red", 0.1)})))
    place = np.zeros((2, 3))
    sink.setup()
    sink.process(Tracks(np.array([7, 0], "i4"), np.ones(2, "u1"), place, place, place))
    assert sink.keeper.slots.known.tolist() == [True]
    sink.close()

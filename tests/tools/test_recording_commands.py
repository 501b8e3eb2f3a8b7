"""`run --record`, `replay`, `verify` and `export` as a user types them."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

import followspot as fs
from followspot.cli.main import main
from followspot.graph.output_ports import chosen_ports
from followspot.graph.plan import Plan, PlannedStage, PlannedWorker
from followspot.room import Member
from followspot.testing import tiny_room
from followspot_record.comparison import Compared
from followspot_record.embedded import recorded_plan
from followspot_record.record import Target, with_recording
from followspot_record.verify import text
from followspot_recording.recording import Recording

GRAPHS = Path(__file__).parents[2] / "graphs"
GLOWBALLS = str(GRAPHS / "glowballs.yaml")
FRAMES = 6
BEATS = """
import numpy as np
from followspot import Message, Source, Stage, at
from followspot.messages import Array, column

class Beat(Message):
    bar: int
    loud: Array = column("N", dtype="f8", unit="1")

class Drum(Stage):
    def process(self) -> Source[Beat]:
        for bar in range(12):
            yield at(bar * 10_000_000, Beat(bar, np.full(bar % 3, 0.5)))

class Louder(Stage):
    def process(self, beat: Beat) -> Beat:
        return Beat(beat.bar, 2.0 * beat.loud)

class Listen(Stage):
    def process(self, beat: Beat) -> None:
        assert type(beat) is Beat
        with (self.context.out / "beats.txt").open("a") as file:
            file.write(f"{beat.bar} {beat.loud.sum()}\\n")
"""
"""A stranger's plugin with a message type of its own."""
BEAT_GRAPH = """
graph: beats
stages:
  drum: {uses: beats.drum}
  louder: {uses: beats.louder, in: {beat: drum}}
  listen: {uses: beats.listen, in: {beat: louder}}
"""


@pytest.fixture(scope="module")
def show(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of all ports of the ready graph; its outputs beside it."""
    folder = tmp_path_factory.mktemp("show")
    run = ["run", GLOWBALLS, "--frames", str(FRAMES), "--out", str(folder / "out"), "--quiet", "--json"]
    assert main([*run, "--record", str(folder / "show.mcap")]) == 0
    return folder / "show.mcap"


def replay(show: Path, out: Path, *options: str) -> int:
    return main(["replay", str(show), "--out", str(out), "--quiet", "--json", *options])


def altered(
    show: Path, path: Path, ends: Mapping[str, int] = MappingProxyType({}), **changes: object
) -> Path:
    """The recording with another embedded plan, made by the writer of the mcap package.

    ends: how many messages of these topics it has; all of the others.
    """
    with show.open("rb") as old, path.open("wb") as new:
        reader = make_reader(old)
        writer = Writer(new)
        writer.start()
        for attachment in reader.iter_attachments():
            data = json.loads(attachment.data) if attachment.name == "plan.json" else {}
            if data:
                writer.add_attachment(0, 0, "plan.json", "", json.dumps(data | changes).encode())
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            if message.sequence >= ends.get(channel.topic, FRAMES):
                continue
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                topic = channel.topic, channel.message_encoding
                channels[channel.id] = writer.register_channel(*topic, schemas[schema.id])
            data_of = message.data
            writer.add_message(channels[channel.id], message.log_time, data_of, 0, message.sequence)
        writer.finish()
    return path


def test_every_port_is_recorded_and_nothing_is_lost(show: Path) -> None:
    with Recording(show) as recording:
        assert recording.problem == ""
        assert len(recording.ports) == 20
        assert {len(list(recording.messages(port))) for port in recording.ports} == {FRAMES}


def test_the_graph_the_room_and_the_versions_are_embedded(show: Path) -> None:
    with Recording(show) as recording:
        assert recording.attachment("graph/glowballs.yaml") == Path(GLOWBALLS).read_bytes()
        assert recording.attachment("room/simulated.yaml") == (GRAPHS / "rooms/simulated.yaml").read_bytes()
        assert recording.metadata["graph"] == "glowballs"
        assert recording.metadata["followspot"]
        assert {stage.name for stage in recorded_plan(recording, ()).stages} >= {
            "camera/cam0",
            "track",
            "save",
        }


def test_a_replay_has_the_same_outputs_byte_for_byte(show: Path, tmp_path: Path) -> None:
    assert replay(show, tmp_path) == 0
    assert (tmp_path / "tracks.csv").read_bytes() == (show.parent / "out/tracks.csv").read_bytes()


@pytest.mark.parametrize("ports", ["color,infrared", "fuse", "track.forecast", "bridge,track.forecast"])
def test_a_replay_from_the_middle_has_the_same_outputs(show: Path, tmp_path: Path, ports: str) -> None:
    assert replay(show, tmp_path, "--ports", ports) == 0
    assert len((tmp_path / "tracks.csv").read_text().splitlines()) > FRAMES
    ours, theirs = (tmp_path / "tracks.csv"), show.parent / "out/tracks.csv"
    assert ours.read_bytes() == theirs.read_bytes()


def test_another_graph_is_replayed_on_the_recorded_cameras(show: Path, tmp_path: Path) -> None:
    """Its room names videos that are not there, and nobody needs them."""
    room = (GRAPHS / "rooms/simulated.yaml").read_text()
    gone = room.replace("source: *sim", "source: {uses: cameras.video, with: {path: gone.mkv}}")
    assert gone.count("gone.mkv") == 5
    (tmp_path / "room.yaml").write_text(gone)
    other = ["--graph", GLOWBALLS, "--room", str(tmp_path / "room.yaml"), "--set", "fuse.uses=balls.mean"]
    assert replay(show, tmp_path, *other) == 0
    assert (tmp_path / "tracks.csv").read_bytes() != (show.parent / "out/tracks.csv").read_bytes()


def test_another_graph_is_replayed_on_some_of_the_recorded_cameras(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert replay(show, tmp_path, "--graph", GLOWBALLS, "--cameras", "cam0,cam1") == 0
    edges = json.loads(capsys.readouterr().out.splitlines()[-1])["edges"]
    assert {edge["from"] for edge in edges if edge["from"].startswith("camera/")} == {
        "camera/cam0.out",
        "camera/cam1.out",
    }


def test_a_part_is_replayed(show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert replay(show, tmp_path, "--from", "0.02", "--to", "0.06") == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 2


def test_verify_finds_everything_the_same(show: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(show), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["same"]
    assert {row["messages"] for row in found["ports"]} == {FRAMES}
    assert len(found["ports"]) == 14


def test_verify_says_that_sources_alone_are_not_repeated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "alone.yaml").write_text(
        f"graph: alone\nroom: {GRAPHS / 'rooms' / 'simulated.yaml'}\n"
        "stages:\n"
        "  camera: {uses: room.source, each: cameras}\n"
        "  draw: {uses: sinks.draw, in: {frames: camera}}\n"
    )
    file = str(tmp_path / "alone.mcap")
    assert main(["record", str(tmp_path / "alone.yaml"), "--frames", "2", "--record", file]) == 0
    capsys.readouterr()
    assert main(["verify", file]) == 1
    assert capsys.readouterr().out.endswith("0 ports, 0 messages: nothing is repeated\n")


def test_verify_names_the_first_difference(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Recording(show) as recording:
        plan = json.loads(recording.attachment("plan.json"))
    track = next(stage for stage in plan["stages"] if stage["name"] == "track")
    track["params"]["acceleration_sigma"] *= 2
    changed = altered(show, tmp_path / "b.mcap", stages=plan["stages"])
    assert main(["verify", str(changed), "--json"]) == 1
    rows = {row["port"]: row["difference"] for row in json.loads(capsys.readouterr().out)["ports"]}
    assert rows["track.tracks"].startswith("message ")
    assert "column " in rows["track.tracks"]


def test_verify_says_where_a_recording_ends_before_its_sources(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As that of a run whose worker died: the file is whole, and the sources were ahead.

    A stage that sends more now leaves the same file, so that scripts are not told that all is the same.
    """
    ends = {"/followspot/infrared/cam1/out": 3, "/followspot/track/tracks": 4}
    early = altered(show, tmp_path / "early.mcap", ends)
    assert main(["verify", str(early)]) == 1
    told = capsys.readouterr().out
    assert "early.mcap ends early: infrared/cam1.out has nothing from 0.05 s on" in told
    assert "different" not in told
    assert f"14 ports, {14 * 3} messages: the same up to there" in told


def test_a_message_more_at_the_end_is_a_difference(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shorter = altered(show, tmp_path / "shorter.mcap", {"/followspot/track/tracks": FRAMES - 1})
    assert main(["verify", str(shorter)]) == 1
    assert f"message {FRAMES - 1} is new" in capsys.readouterr().out


def chunks_of(path: Path) -> list[int]:
    """Where the chunks of a recording begin, bytes."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return [chunk.chunk_start_offset for chunk in summary.chunk_indexes]


def test_verify_says_up_to_where_a_damaged_recording_is_good(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    last = max(chunks_of(show))
    cut.write_bytes(show.read_bytes()[: last + 100])
    assert main(["verify", str(cut)]) == 0
    told = capsys.readouterr().out
    assert "read up to there" in told
    assert "the same, byte for byte" in told


def test_verify_says_that_a_recording_was_cut_before_its_sources(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    first = min(chunks_of(show))
    cut.write_bytes(show.read_bytes()[: first + 100])
    assert main(["verify", str(cut)]) == 2
    assert f"damaged at byte {first} of {first + 100}" in capsys.readouterr().err


def test_a_recording_makes_the_folder_that_it_names(tmp_path: Path) -> None:
    file = tmp_path / "out/more/show.mcap"
    words = ["--frames", "2", "--quiet", "--record-ports", "track", "--record", str(file)]
    assert main(["run", GLOWBALLS, *words, "--out", str(tmp_path / "out")]) == 0
    assert file.is_file()


def test_a_recording_that_is_cut_short_is_told_to_scripts_and_by_export(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    half, start = tmp_path / "half.mcap", tmp_path / "start.mcap"
    start.write_bytes(show.read_bytes()[:4000])
    found: list[object] = []
    for chunk in sorted(chunks_of(show))[1:]:  # a busy machine writes fewer messages into each
        half.write_bytes(show.read_bytes()[: chunk + 100])
        with (
            fs.open_recording(half) as recording,
            pytest.warns(UserWarning, match=r"half\.mcap: .*byte"),
        ):
            found = [*recording["track.tracks"]]
        if found:
            break
    assert 0 < len(found) < FRAMES
    with pytest.warns(UserWarning, match=r"start\.mcap"):
        fs.open_recording(start).close()
    assert main(["export", str(start), str(tmp_path / "out"), "--to", "csv"]) == 2
    assert "start.mcap: " in capsys.readouterr().err.replace(f"{start} has no such ports", "")


def test_the_last_line_of_verify_counts_the_ports_that_are_not_repeated() -> None:
    repeated, left = Compared("track.tracks", 12), Compared("verify.out", 0, unrepeated="its type differs")
    assert text(True, [repeated], []).endswith("1 ports, 12 messages: the same, byte for byte")
    assert text(True, [repeated, left], []).endswith(
        "1 ports, 12 messages: the same, byte for byte; 1 of 2 recorded ports not repeated"
    )


def test_a_recording_from_elsewhere_writes_nothing_outside_and_loads_no_file(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Recording(show) as recording:
        plan = json.loads(recording.attachment("plan.json"))
    (tmp_path / "evil.py").write_text("raise SystemExit('loaded')")
    strange = altered(show, tmp_path / "a.mcap", plugin_files=[str(tmp_path / "evil.py")])
    assert replay(strange, tmp_path / "out") == 0
    save = next(stage for stage in plan["stages"] if stage["name"] == "save")
    save["params"]["path"] = str(tmp_path / "outside.csv")
    strange = altered(show, tmp_path / "b.mcap", stages=plan["stages"])
    assert replay(strange, tmp_path / "out2") == 2
    assert 'the recorded stage "save" would write' in capsys.readouterr().err
    assert not (tmp_path / "outside.csv").exists()


TRACKS = "frame,time,object,state,x,y,z,vx,vy,vz,sx,sy,sz"


def test_ports_become_tables_and_lines(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(show), str(tmp_path), "--to", "csv", "--ports", "track.tracks,color"]) == 0
    with (tmp_path / "track.tracks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["frame"] for row in rows} == set(map(str, range(FRAMES)))
    assert list(rows[0])[:-2] == [*TRACKS.split(",")], "the columns of sinks.csv"
    assert list(rows[0])[-2:] == ["source", "time_ns"]
    assert all(int(row["time_ns"]) == round(1e9 * float(row["time"])) for row in rows)
    assert all(abs(float(row["z"])) < 5 for row in rows)
    assert {row["object"] for row in rows} == {"green", "red", "blue"}
    assert (tmp_path / "color.cam0.out.csv").exists()
    assert main(["export", str(show), str(tmp_path), "--to", "jsonl", "--json"]) == 0
    lines = (tmp_path / "track.forecast.jsonl").read_text().splitlines()
    assert len(lines) == FRAMES
    assert [row["object"] for row in json.loads(lines[0])["rows"]] == ["green", "red", "blue"]
    assert not list(tmp_path.glob("camera*"))


def test_an_export_replaces_no_file(show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edited = tmp_path / "track.tracks.csv"
    edited.write_text("edited by hand\n")
    words = ["export", str(show), str(tmp_path), "--to", "csv", "--ports"]
    assert main([*words, "track"]) == 2
    said = capsys.readouterr().err
    assert f"{edited} exists already" in said
    assert "name another folder, or remove it" in said
    assert [path.name for path in tmp_path.iterdir()] == [edited.name], "nothing is written then"
    assert edited.read_text() == "edited by hand\n"
    assert main([*words, "track.forecast"]) == 0


def test_parquet_has_the_rows_of_the_table_with_their_types(show: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    for form in ("csv", "parquet"):
        ports = ["--ports", "track,verify"]
        assert main(["export", str(show), str(tmp_path), "--to", form, *ports]) == 0
    for port in ("track.tracks", "track.forecast", "verify.out"):
        with (tmp_path / f"{port}.csv").open(newline="") as file:
            lines = list(csv.DictReader(file))
        table = parquet.read_table(tmp_path / f"{port}.parquet")
        assert table.num_rows == len(lines) > 0
        assert table.column_names == list(lines[0])
    assert str(table.schema.field("epipolar").type) == "double"
    assert table["epipolar"].to_pylist() == [float(line["epipolar"]) for line in lines]


def test_a_file_for_the_rerun_viewer_is_written(show: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    ports = ["--ports", "track.tracks,camera/cam0,color/cam0,verify"]
    assert main(["export", str(show), str(tmp_path), "--to", "rerun", *ports]) == 0
    sizes = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    assert sizes.keys() == {"track.tracks.rrd", "camera.cam0.out.rrd", "color.cam0.out.rrd", "verify.out.rrd"}
    assert all(path.read_bytes().startswith(b"RRF") for path in tmp_path.iterdir())
    assert sizes["camera.cam0.out.rrd"] > sizes["track.tracks.rrd"] > 1000


def test_messages_of_a_stranger_are_recorded_replayed_and_verified(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plugin, graph, show = tmp_path / "beats.py", tmp_path / "beats.yaml", tmp_path / "beats.mcap"
    plugin.write_text(BEATS)
    graph.write_text(BEAT_GRAPH)
    mine = ["--plugin", str(plugin)]
    run = ["run", str(graph), *mine, "--out", str(tmp_path / "a"), "--quiet", "--record", str(show)]
    assert main(run) == 0
    heard = (tmp_path / "a/beats.txt").read_bytes()
    assert len(heard.splitlines()) == 12
    for part, ports in (("b", ()), ("c", ("--ports", "louder"))):
        assert replay(show, tmp_path / part, *mine, *ports) == 0
        assert (tmp_path / part / "beats.txt").read_bytes() == heard
    capsys.readouterr()
    assert main(["verify", str(show), *mine, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["ports"]
    assert row == {"port": "louder.out", "messages": 12, "difference": "", "unrepeated": ""}


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["run", GLOWBALLS, "--record", "SHOW"], "exists already"),
        (["run", GLOWBALLS, "--record", "a.txt"], "is no .mcap"),
        (["check", GLOWBALLS, "--record", "a.mcap", "--record-ports", "tracks"], 'no port "tracks"'),
        (["record", GLOWBALLS], "needs a file"),
        (["replay", "SHOW", "--ports", "fusee"], 'did you mean "fuse"?'),
        (["replay", "SHOW", "--set", "fuse.uses=balls.mean"], "add --graph GRAPH"),
        (["replay", "SHOW", "--cameras", "cam0"], "--cameras serves another graph"),
        (["replay", "SHOW", "--from", "2", "--to", "1"], "0 <= from < to"),
        (["replay", "SHOW", "--from", "1e300"], "0 <= from < to"),
        (["replay", "SHOW", "--from", "2"], "it lasts 0.0833333 s"),
        (["replay", "SHOW", "--from", "1e-300"], "0 <= from < to"),
        (["replay", "SHOW", "--to", "1e300"], "0 <= from < to"),
        (["replay", "SHOW", "--to", "1e-300"], "0 <= from < to"),
        (["replay", "SHOW", "--to", "nan"], "0 <= from < to"),
        (["replay", "SHOW", "--speed", "nan"], "--speed cannot be nan"),
        (["replay", "SHOW", "--speed", "1e-300"], "--speed cannot be 1e-300"),
        (["export", "SHOW", "out", "--to", "csv", "--ports", "nothing"], 'no port "nothing"'),
    ],
)
def test_a_mistake_is_named_with_its_remedy(
    show: Path, capsys: pytest.CaptureFixture[str], command: list[str], said: str
) -> None:
    assert main([str(show) if word == "SHOW" else word for word in command]) == 2
    assert said in capsys.readouterr().err


def test_what_is_no_recording_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mcap").write_text("hello")
    assert main(["verify", str(tmp_path / "a.mcap")]) == 1
    assert "a.mcap is no recording" in capsys.readouterr().err
    assert main(["replay", str(tmp_path / "none.mcap")]) == 1
    assert "No such file" in capsys.readouterr().err


def test_words_choose_ports() -> None:
    ports = ("camera/cam0.out", "camera/cam1.out", "track.tracks", "track.forecast")
    assert chosen_ports("camera", ports, "--ports") == ports[:2]
    assert chosen_ports("track.tracks, camera/cam1", ports, "--ports") == ports[1:3]
    assert chosen_ports(None, ports, "--ports") == ports


@pytest.mark.parametrize(
    ("live", "size", "depth"), [(True, (320, 240), 128), (True, (3840, 2160), 32), (False, (320, 240), 32)]
)
def test_a_live_camera_may_be_two_seconds_ahead_of_the_disk_where_memory_allows(
    tmp_path: Path, live: bool, size: tuple[int, int], depth: int
) -> None:
    room = tiny_room()
    cameras = {name: replace(camera, size=size) for name, camera in room.cameras.items()}
    camera = PlannedStage("camera/cam0", "camera", "sim.camera", {}, Member("cameras", "cam0"), "main", live)
    plan = Plan("toy", replace(room, cameras=cameras), (camera,), (), (PlannedWorker("main"),))
    target = Target(tmp_path / "a.mcap", {}, {}, {})
    (edge,) = with_recording(plan, ["camera/cam0.out"], target).edges
    assert edge.depth == depth

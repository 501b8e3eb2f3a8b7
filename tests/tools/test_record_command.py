"""`run --record`, `record` and `replay` as a user types them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.tools.recorded_show import FRAMES, GLOWBALLS, GRAPHS, altered, recorded, replay

from followspot.cli.main import main
from followspot.graph.output_ports import chosen_ports
from followspot.graph.plan import Plan, PlannedStage, PlannedWorker
from followspot.room import Member
from followspot.testing import tiny_room
from followspot_record.embedded import recorded_plan
from followspot_record.record import Target, with_recording
from followspot_recording.recording import Recording

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
    return recorded(tmp_path_factory.mktemp("show"))


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


def test_a_replay_names_the_sources_that_were_not_recorded(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They run as the graph declares them, beside the recorded ones."""
    part = tmp_path / "part.mcap"
    chosen = ["--record", str(part), "--record-ports", "camera/cam0,camera/cam1,camera/cam3"]
    run = ["record", GLOWBALLS, "--set", f"camera.frames={FRAMES}", "--out", str(tmp_path), "--quiet"]
    assert main([*run, *chosen]) == 0
    capsys.readouterr()
    notes = []
    for path in (part, show):
        assert replay(path, tmp_path) == 0
        notes.append(json.loads(capsys.readouterr().out)["notes"])
    assert [note for note in notes[0] if note.endswith("declares: camera/cam2, camera/cam4, camera/cam5")]
    assert not any("declares" in note for note in notes[1])


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
    """Its room names videos that are not there; a replay opens none of them."""
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


def test_a_recording_makes_the_folder_that_it_names(tmp_path: Path) -> None:
    file = tmp_path / "out/more/show.mcap"
    words = ["--frames", "2", "--quiet", "--record-ports", "track", "--record", str(file)]
    assert main(["run", GLOWBALLS, *words, "--out", str(tmp_path / "out")]) == 0
    assert file.is_file()


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


def test_a_recording_whose_plan_is_none_is_refused_with_its_name(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    strange = altered(show, tmp_path / "strange.mcap", stages="none")
    assert replay(strange, tmp_path / "out") != 0
    assert f"{strange}: plan.json: this is no plan" in capsys.readouterr().err


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

"""Runs with a flight recorder: `run --keep`, `followspot mark`, `fs.run(keep=)`, and faults that mark."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from mcap.reader import make_reader
from tests.commands import COMMAND, command
from tests.tools.flight.bars import fire, running

import followspot as fs
from followspot.cli.main import main
from followspot.errors import FollowspotError, InputError
from followspot.library.handle import RunHandle, run_here
from followspot.tracking import Blobs
from followspot_recording.recording import Recording

CLOCK = """
import time
import numpy as np
from followspot import Field, Message, Source, Stage, StageParams, at
from followspot.messages import Array, column

class Beat(Message):
    bar: int
    loud: Array = column("N")

class Drum(Stage):
    live = True

    class Params(StageParams):
        beats: int = Field(100_000, description="number")

    def process(self) -> Source[Beat]:
        for bar in range(self.params.beats):
            if not self.context.pause(0.01):
                return
            yield Beat(bar, np.full(bar % 3, 0.5))

class Louder(Stage):
    class Params(StageParams):
        torn: bool = Field(False, description="whether it fails")

    def process(self, beat: Beat) -> Beat:
        if self.params.torn:
            raise RuntimeError("the skin is torn")
        return Beat(beat.bar, 2.0 * beat.loud)

class Listen(Stage):
    def process(self, beat: Beat) -> None:
        pass
"""
GRAPH = """
graph: beats
stages:
  drum: {uses: clock.drum}
  louder: {uses: clock.louder, in: {beat: drum}}
  listen: {uses: clock.listen, in: {beat: louder}}
"""
TIMEOUT = 60.0


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A live graph with messages of its own."""
    folder = tmp_path_factory.mktemp("graph")
    (folder / "clock.py").write_text(CLOCK)
    (folder / "beats.yaml").write_text(GRAPH)
    return folder / "beats.yaml"


def wait_until(happens: Callable[[], bool]) -> None:
    deadline = time.monotonic() + TIMEOUT
    while not happens():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def held(run: RunHandle) -> float:
    kept = run.kept()
    return 0.0 if kept is None else kept.held


def bars(path: str, port: str) -> list[int]:
    with Recording(path) as recording:
        assert recording.problem == ""
        return [message.seq for message in recording.messages(port)]


def facts_of(path: Path) -> dict[str, dict[str, str]]:
    with path.open("rb") as file:
        return {record.name: record.metadata for record in make_reader(file).iter_metadata()}


def told_of_moments(run: fs.Run) -> list[str]:
    """What the log of a run tells of moments."""
    return [record.text for record in run.log().records if "moment" in record.text]


def test_a_script_marks_a_moment_and_reads_it(graph: Path, tmp_path: Path) -> None:
    plugin = graph.with_name("clock.py")
    with fs.run(graph, plugin_files=[plugin], out=tmp_path, keep="1s") as run:
        wait_until(lambda: held(run) > 0.5)
        moment = run.mark(after=0.2, note="loud", wait=True)
        known = run.kept()
        wait_until(lambda: len(told_of_moments(run)) == 2)  # records come by themselves
        assert told_of_moments(run) == [
            f"a moment is marked (loud): {moment.file}",
            f"the marked moment is saved (loud): {moment.file}, {moment.seconds:.1f} s, "
            f"{moment.messages} messages, {moment.bytes / 1e6:.1f} MB, 0 missing",
        ]
        counts = [count for edge, count in run.status().edges(run.plan()) if edge.from_stage == "drum"]
        run.stop()
    assert known is not None
    assert (known.seconds, known.ports, known.lost) == (1.0, 2, 0)
    assert moment.seconds >= 0.7
    with fs.open_recording(moment.file) as recording:
        assert recording.ports == ("drum.out", "louder.out")
        messages = list(recording["louder.out"])
    found = bars(moment.file, "drum.out")
    absent = set(range(found[0], found[-1] + 1)) - set(found)
    assert len(absent) <= counts[0].dropped, "none is missing but those that the source dropped"
    assert len(found) > 1
    assert messages
    assert all(set(message.loud) <= {1.0} for message in messages)  # type: ignore[attr-defined]


def test_a_run_that_keeps_nothing_cannot_be_marked(graph: Path, tmp_path: Path) -> None:
    with fs.run(graph, plugin_files=[graph.with_name("clock.py")], out=tmp_path) as run:
        with pytest.raises(FollowspotError, match='start it with keep="30s"'):
            run.mark()
        run.stop()


def recorder_of(operator: int) -> int:
    """The process of the flight recorder that a process has started."""
    for found in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            mine = found.joinpath("stat").read_text().rpartition(")")[2].split()[1] == str(operator)
            if mine and b"followspot_record.flight.process" in found.joinpath("cmdline").read_bytes():
                return int(found.name)
    raise AssertionError("there is no flight recorder")


def test_a_recorder_that_dies_is_told_and_the_run_goes_on(
    graph: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with fs.run(graph, plugin_files=[graph.with_name("clock.py")], out=tmp_path, keep="5s") as run:
        os.kill(recorder_of(os.getpid()), signal.SIGKILL)
        said = ""

        def told() -> bool:
            nonlocal said
            said += capsys.readouterr().err
            return "the flight recorder has ended; the run goes on" in said

        wait_until(told)
        with pytest.raises(FollowspotError, match="flight recorder of this run has ended"):
            run.mark()
        fired = run.status().fired
        wait_until(lambda: run.status().fired > fired + 20)
        run.stop()
    assert run.report.ok


def test_a_condition_and_a_stage_that_fails_save_the_last_seconds(graph: Path, tmp_path: Path) -> None:
    keep = fs.Keep(30.0, mark_when=("louder: bar >= 100 and count(loud == 1) == 2",))
    run = fs.run(graph, plugin_files=[graph.with_name("clock.py")], out=tmp_path, keep=keep)
    wait_until(lambda: any(keep.mark_when[0] in record.text for record in run.log().records))
    wait_until(lambda: held(run) > 0.5)
    run.set("louder.torn", True)
    with pytest.raises(FollowspotError, match="the skin is torn"):
        run.wait()
    run.close()
    (path,) = tmp_path.glob("moment-*.mcap")
    found = bars(str(path), "louder.out")
    assert found[-1] - found[0] > 40, "half a second, of which a live run may have dropped some"
    assert bars(str(path), "drum.out")[-1] > found[-1], "also the message at which it failed"
    texts = [fact["text"] for name, fact in facts_of(path).items() if name.startswith("mark ")]
    assert texts[0] == f"marked: {keep.mark_when[0]}"
    assert "the skin is torn" in texts[-1]


def test_the_command_line_keeps_and_marks_and_a_failure_marks_by_itself(graph: Path, tmp_path: Path) -> None:
    words = ["run", str(graph), "--plugin", str(graph.with_name("clock.py")), "--out", str(tmp_path), "-q"]
    keep = ["--keep", "2s", "--keep-ports", "louder", "--keep-memory", "8MiB"]
    process = subprocess.Popen([*COMMAND, *words, *keep], stderr=subprocess.PIPE, text=True)

    def ready() -> bool:
        try:
            return held(run_here(str(process.pid))) > 0.5
        except FollowspotError:
            return False

    wait_until(ready)
    said = command(
        "mark", "--run", str(process.pid), "--after", "100ms", "--note", "now", "--json", check=True
    )
    moment = json.loads(said.stdout)
    run_here(str(process.pid)).set("louder.torn", True)
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 1
    assert f"{moment['file']}: " in errors
    assert "s of the run, as marked" in errors
    assert (moment["state"], moment["notes"], moment["lost"]) == ("complete", ["now"], 0)
    with Recording(moment["file"]) as recording:
        assert set(recording.ports) == {"louder.out"}
        assert recording.attachment("graph/beats.yaml") == graph.read_bytes()
    facts = facts_of(Path(moment["file"]))
    assert facts["mark 1"]["text"] == "marked: now"
    assert "the skin is torn" in facts["mark 2"]["text"], "it overlaps with the first"


PART = """
inputs: {beat: soft.beat}
outputs: {beat: soft}
stages:
  soft: {uses: clock.louder}
"""
OTHER = """
inputs: {beat: soft.beat}
outputs: {beat: loud}
stages:
  soft: {uses: clock.louder}
  loud: {uses: clock.louder, in: {beat: soft}}
"""
HALL = """
graph: hall
stages:
  drum: {uses: clock.drum}
  hall: {graph: part.yaml, in: {beat: drum}}
  listen: {uses: clock.listen, in: {beat: hall}}
"""


def test_stages_that_a_swap_brings_are_kept_and_verified(
    graph: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, text in (("part", PART), ("other", OTHER), ("hall", HALL)):
        (tmp_path / f"{name}.yaml").write_text(text)
    plugin = graph.with_name("clock.py")
    with fs.run(tmp_path / "hall.yaml", plugin_files=[plugin], out=tmp_path / "out", keep="2s") as run:
        wait_until(lambda: held(run) > 0.5)
        run.swap("hall", str(tmp_path / "other.yaml"))
        wait_until(lambda: (kept := run.kept()) is not None and kept.ports == 3 and kept.held > 0.5)
        moment = run.mark(after=0.2, wait=True)
        run.stop()
    assert len(bars(moment.file, "hall/loud.out")) > 10
    capsys.readouterr()
    assert main(["verify", moment.file, "--plugin", str(plugin), "--json"]) == 0
    found = {port["port"]: port for port in json.loads(capsys.readouterr().out)["ports"]}
    assert set(found) == {"hall/soft.out", "hall/loud.out"}
    assert found["hall/loud.out"]["messages"] > 10


def test_a_recording_is_verified_up_to_the_swap_that_takes_its_stage_away(
    graph: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, text in (("part", PART), ("other", OTHER), ("hall", HALL)):
        (tmp_path / f"{name}.yaml").write_text(text)
    plugin, path = graph.with_name("clock.py"), tmp_path / "show.mcap"
    words = (tmp_path / "hall.yaml", "--plugin", plugin, "--out", tmp_path / "out", "--record", path)
    with running(*words, "--record-ports", "drum,hall.beat") as run:
        run.swap("hall", str(tmp_path / "other.yaml"))
        fire(run, 50)
    recorded = len(bars(str(path), "hall/soft.out"))
    capsys.readouterr()
    assert main(["verify", str(path), "--plugin", str(plugin), "--json"]) == 0
    (port,) = json.loads(capsys.readouterr().out)["ports"]
    assert port["port"] == "hall/soft.out"
    assert 10 < port["messages"] < recorded, "what the file sends that came is the other stage's"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--keep", "soon"], "is no time"),
        (["--keep", "5s", "--keep-ports", "luder"], 'did you mean "louder"'),
        (["--keep", "5s", "--keep-memory", "much"], "write for example 512MiB"),
        (["--keep-ports", "louder"], "--keep 30s"),
        (["--keep", "5s", "--mark-when", "drum: lout > 1"], 'did you mean "loud"'),
        (["--keep", "5s", "--keep-ports", "drum", "--mark-when", "louder: bar > 1"], "no port"),
    ],
)
def test_wrong_options_are_told_before_anything_starts(
    graph: Path, options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(graph), "--plugin", str(graph.with_name("clock.py")), *options]) == 2
    assert message in capsys.readouterr().err


def test_a_class_of_this_process_is_told_to_move_into_a_file(tmp_path: Path) -> None:
    class Tick(fs.Stage):
        def process(self) -> fs.Source[Blobs]:
            yield from ()

    graph = fs.Graph("ticks")
    graph.add("tick", Tick)
    with pytest.raises(InputError, match="put it into a file"):
        fs.run(graph, out=tmp_path, keep="1s")

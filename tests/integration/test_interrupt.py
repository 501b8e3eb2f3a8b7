"""Ctrl-C ends a run at a slow pace at once: neither its sources nor its summary wait."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from tests.commands import Started, launch
from tests.integration.running import STAGES, Finished, finish, run, start, wait_until, write_graph

from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.operator.reporting.truth import room_truth

GRAPHS = Path(__file__).parents[2] / "graphs"
FPS = 0.01
"""Frames are 100 s apart: longer than any test waits."""
TELL = """
from followspot import Stage
from followspot.tracking import Frame

class Tell(Stage):
    def process(self, frame: Frame) -> None:
        (self.context.out / "came").write_text("yes")
"""


def interrupted(process: Started, came: Path) -> Finished:
    """The end of a run that gets Ctrl-C after its first frame."""
    wait_until(lambda: process.poll() is not None or (came.exists() and came.stat().st_size > 0), 60.0)
    process.send_signal(signal.SIGINT)
    return finish(process, came.parent)  # gives up long before the second frame is due


HELD = """
import time
from followspot import Stage
from followspot.tracking import Frame

class Held(Stage):
    def process(self, frame: Frame) -> None:
        (self.context.out / "came").write_text("yes")

    def close(self) -> None:
        while not (self.context.out / "go").exists():
            time.sleep(0.01)
"""


def test_a_stopped_run_says_what_is_still_to_be_finished(tmp_path: Path) -> None:
    (tmp_path / "held.py").write_text(HELD)
    held = "held: {uses: held.held, each: cameras, in: {frame: camera}}"
    stages = f"{{camera: {{uses: room.source, each: cameras}}, {held}}}"
    graph, out = tmp_path / "graph.yaml", tmp_path / "out"
    graph.write_text(f"graph: g\nroom: {GRAPHS / 'rooms/simulated.yaml'}\nstages: {stages}\n")
    process = launch("run", graph, "--plugin", tmp_path / "held.py", "--out", out, "--json")
    wait_until(lambda: process.poll() is not None or (out / "came").exists(), 60.0)
    assert (out / "came").exists()
    process.send_signal(signal.SIGINT)
    said = next((line for line in process.stderr if "still to be finished" in line), "")
    (out / "go").touch()
    assert "stopped; still to be finished: held/cam0, held/cam1, held/cam2, held/cam3 and 2 more" in said
    assert finish(process, out).summary["stopped"]


def slow(folder: Path, name: str) -> Path:
    """A shipped room that plays in real time, one frame every 100 s."""
    before, fps, after = (GRAPHS / "rooms" / name).read_text().partition("fps: ")
    assert fps
    path = folder / name
    path.write_text(f"{before}realtime: true, fps: {FPS}{after[after.index(',') :]}")
    return path


@pytest.mark.parametrize("placement", [(), ("--placement", "camera")], ids=["one process", "per camera"])
def test_a_simulated_room_in_real_time_ends_before_its_second_frame_is_due(
    tmp_path: Path, placement: tuple[str, ...]
) -> None:
    (tmp_path / "tell.py").write_text(TELL)
    stages = (GRAPHS / "glowballs.yaml").read_text().partition("stages:\n")[2]
    stages += "  tell: {uses: tell.tell, each: cameras, in: {frame: camera}}\n"
    graph = tmp_path / "graph.yaml"
    graph.write_text(f"graph: g\nstages:\n{stages}")
    room, plugin = slow(tmp_path, "simulated.yaml"), tmp_path / "tell.py"
    options = ("--room", str(room), "--plugin", str(plugin), *placement)
    finished = interrupted(start(graph, tmp_path / "out", *options), tmp_path / "out" / "came")
    assert finished.code == 0, finished.errors
    assert finished.summary["stopped"]
    assert finished.summary["frames"] <= 2
    assert (finished.out / "tracks.csv").read_text().startswith("frame,time,object")


def test_a_replay_in_real_time_ends_before_its_second_message_is_due(tmp_path: Path) -> None:
    graph = write_graph(tmp_path, "a: {uses: ticks.count}\nsave: {uses: ticks.write, in: {number: a}}")
    recording, out = tmp_path / "r.mcap", tmp_path / "again"
    assert run(graph, "--record", str(recording)).code == 0
    words = ["replay", recording, "--speed", "0.00001", "--plugin", STAGES, "--out", out, "--json"]
    finished = interrupted(launch(*words), out / "ticks.csv")
    assert finished.code == 0, finished.errors
    assert finished.summary["stopped"]
    assert len(finished.values()) <= 2


def test_the_truth_of_a_room_in_real_time_is_read_at_once(tmp_path: Path) -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml", room=slow(tmp_path, "simulated.yaml"))
    truth = room_truth(plan, 2)
    assert truth is not None


def test_reading_the_truth_of_a_stopped_run_has_a_time_limit(tmp_path: Path) -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml")
    with pytest.raises(FollowspotError, match="the truth of 0 frames took"):
        room_truth(plan, 100, seconds=0.0)


STUCK = """
import threading
from followspot import Source, Stage, at
from followspot_file_ticks import Tick, tick

class Count(Stage):
    '''One number, and never another.'''

    def process(self) -> Source[Tick]:
        yield at(0, tick(0))
        (self.context.out / "came").write_text("yes")
        threading.Event().wait()
"""


def stuck(folder: Path, *options: str | Path) -> tuple[Started, Path]:
    """A run whose source never returns, after its first number, and its output folder."""
    (folder / "stuck.py").write_text(STUCK)
    graph = write_graph(folder, "a: {uses: stuck.count}\nsave: {uses: sinks.jsonl, in: {message: a}}")
    process = start(graph, folder / "out", "--plugin", str(folder / "stuck.py"), *map(str, options))
    assert wait_until(lambda: (folder / "out/came").exists(), 60.0)
    return process, folder / "out"


def test_ctrl_c_twice_ends_a_run_in_one_process_whose_source_never_returns(tmp_path: Path) -> None:
    process, _ = stuck(tmp_path)
    process.send_signal(signal.SIGINT)
    assert next((line for line in process.stderr if "still to be finished" in line), "")
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.wait() == 130
    assert "followspot: interrupted" in errors


@pytest.mark.thorough
def test_ctrl_c_ends_a_run_in_one_process_whose_source_never_returns(tmp_path: Path) -> None:
    process, out = stuck(tmp_path)
    process.send_signal(signal.SIGINT)
    finished = finish(process, out)
    assert finished.code == 1
    (error,) = finished.summary["errors"]
    assert "in which stage a was at work: a stage does not return" in error


@pytest.mark.thorough
def test_a_source_that_never_returns_costs_other_workers_none_of_their_outputs(tmp_path: Path) -> None:
    process, out = stuck(tmp_path, "--placement", "stage")
    process.send_signal(signal.SIGINT)
    finished = finish(process, out)
    assert finished.code == 1
    assert len(finished.lines("messages.jsonl")) == 1
    (error,) = [error for error in finished.summary["errors"] if "worker a" in error]
    assert error.endswith("in which stage a was at work")

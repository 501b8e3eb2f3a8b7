"""Ports that a script subscribes to while the run goes on: the newest messages, and a count of the rest."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from time import monotonic, sleep

import pytest
from tests.integration.running import workers

import followspot as fs
from followspot.control.tapping import Tapping
from followspot.taps import sender

ROOT = Path(__file__).parents[3]
GRAPH = ROOT / "graphs" / "glowballs.yaml"
TICKS = ROOT / "tests" / "stages" / "ticks.py"
COUNT = 5000
STAGES = f"""
  a: {{uses: ticks.count, with: {{count: {COUNT}}}}}
  b: {{uses: ticks.add, in: {{number: a}}}}
"""
LIVE = """
  a: {uses: ticks.live, with: {count: 1000000000, period: 0.02}}
  b: {uses: ticks.add, in: {number: a}}
"""
TWO = "{left: {stages: [a]}, right: {stages: [b]}}"


def begun(
    folder: Path, stages: str, *ports: str, workers: str = "", plugins: Sequence[Path] = ()
) -> fs.OwnRun:
    """A run of these stages; workers: of a placement, none for one process."""
    graph, placement = folder / "graph.yaml", folder / "placement.yaml"
    graph.write_text(f"graph: later\nstages:{stages}")
    placement.write_text(f"placement: two\nworkers: {workers}\n")
    return fs.run(
        graph,
        plugin_files=[TICKS, *plugins],
        ports=ports,
        out=folder / "out",
        placement=placement if workers else None,
    )


def comes_true(condition: Callable[[], bool]) -> bool:
    deadline = monotonic() + 60.0
    while not condition() and monotonic() < deadline:
        sleep(0.01)
    return condition()


@pytest.mark.parametrize("workers", ["", TWO], ids=["one", "two"])
def test_every_message_since_the_first_is_read_or_counted(tmp_path: Path, workers: str) -> None:
    came = threading.Event()
    with begun(tmp_path, STAGES, "b", workers=workers) as run:

        def read_all() -> None:
            for _ in run["b"]:
                came.wait(0.01)  # holds the replay up until a tap has been placed

        reader = threading.Thread(target=read_all)
        reader.start()
        late = run["a"]
        first = next(late)
        came.set()
        reader.join()
        rest = list(late)
        assert rest[-1].header.seq == COUNT - 1
        assert late.dropped > 0
        assert COUNT - 1 - first.header.seq <= len(rest) + late.dropped <= COUNT - 1  # some before the first
    assert run.report.ok


def test_messages_that_the_tap_drops_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sender, "MAX_WAITING", 400)  # bytes: few messages wait for the socket
    with begun(tmp_path, STAGES, "b") as run:
        late = run["a"]

        def read_all() -> None:
            for number in run["b"]:
                if number.header.seq < 100:
                    sleep(0.01)

        reader = threading.Thread(target=read_all)
        reader.start()
        numbers = [message.header.seq for message in late]
        reader.join()
    assert numbers[-1] - numbers[0] < len(numbers) + late.dropped <= numbers[-1] + 1  # some before the first
    assert late.dropped > 0


def test_leaving_the_loop_removes_the_tap_and_another_loop_places_a_new_one(tmp_path: Path) -> None:
    with begun(tmp_path, LIVE) as run:
        for number in run["b"]:
            if number.header.seq > 5:
                break
        assert comes_true(lambda: not sender._senders), "the tap stays"
        again = run["b"]
        assert next(again).header.seq > number.header.seq
        assert run["b"] is again
        with pytest.raises(fs.InputError, match='there is no port "c"'):
            run["c"]
    assert next(again, None) is None
    assert comes_true(lambda: not sender._senders)
    with pytest.raises(fs.FollowspotError, match="the run has ended"):
        run["a"]


WITNESS = """
from pathlib import Path
from followspot import Field, Message, Stage, StageParams

class Witness(Stage):
    \"\"\"Writes down when it begins and ends.\"\"\"

    tap = True

    class Params(StageParams):
        path: str = Field("", description="file")

    def setup(self) -> None:
        self.note("begun")

    def process(self, message: Message) -> None:
        return

    def close(self) -> None:
        self.note("closed")

    def note(self, word: str) -> None:
        with Path(self.params.path).open("a") as file:
            file.write(word + " ")
"""


def test_a_removed_tap_does_not_come_back_with_a_worker_that_restarts(tmp_path: Path) -> None:
    (tmp_path / "witness.py").write_text(WITNESS)
    removed, kept = tmp_path / "removed", tmp_path / "kept"
    taps = [Tapping("b.out", "witness.witness", {"path": str(path)}) for path in (removed, kept)]
    with begun(tmp_path, LIVE, workers=TWO, plugins=[tmp_path / "witness.py"]) as run:
        run.tap(taps)
        assert comes_true(lambda: removed.exists() and kept.exists())
        run.untap(taps[:1])
        assert comes_true(lambda: removed.read_text() == "begun closed ")
        for worker in workers(os.getpid()):
            os.kill(worker, signal.SIGKILL)
        assert comes_true(lambda: kept.read_text() == "begun begun ")
        assert removed.read_text() == "begun closed "
        assert comes_true(lambda: all(worker.phase == "running" for worker in run.status().workers))
    assert kept.read_text() == "begun begun closed "


def test_leaving_the_loop_of_a_lossless_port_lets_the_run_go_on(tmp_path: Path) -> None:
    with begun(tmp_path, STAGES, "b") as run:
        for _ in run["b"]:
            break
        assert run.wait().frames == COUNT
        assert list(run["b"]) == []


def test_cameras_in_processes_of_their_own_are_heard_together(tmp_path: Path) -> None:
    endless = {"camera.realtime": True, "camera.frames": 0}
    with fs.run(GRAPH, set=endless, placement="camera", out=tmp_path) as run:
        heard = set()
        for blobs in run["color"]:
            heard.add(blobs.header.source)
            if len(heard) == 3:
                break
    assert all(source.startswith("camera/cam") for source in heard)


def test_a_run_of_another_handle_is_heard_to_its_end(tmp_path: Path) -> None:
    with (
        begun(tmp_path, LIVE, workers="{left: {stages: [a]}, right: {stages: [b]}}") as run,
        fs.connect(run.run) as other,
    ):
        messages = iter(other["a,b"])
        assert {type(next(messages)).__name__ for _ in range(3)} == {"Tick"}
        other.stop()
        assert all(message.header.seq >= 0 for message in messages)
        assert other["a,b"].dropped >= 0 if not other.over() else True
        run.wait()


def test_closing_the_handle_ends_its_loops_and_leaves_the_run(tmp_path: Path) -> None:
    with begun(tmp_path, LIVE) as run:
        with fs.connect(run.run) as other:
            messages = other["b"]
            next(messages)
        assert messages.closed
        assert next(messages, None) is None
        assert not run.over()


def test_a_cancelled_task_lets_go_of_its_port(tmp_path: Path) -> None:
    async def read(run: fs.OwnRun) -> fs.Subscription:
        late = run["b"]
        async for _ in late:
            break
        return late

    with begun(tmp_path, LIVE) as run:
        assert asyncio.run(read(run)).closed
        assert comes_true(lambda: not sender._senders)


@pytest.mark.thorough
def test_a_subscription_follows_a_stage_that_moves(tmp_path: Path) -> None:
    stages = f"{LIVE}  c: {{uses: ticks.add, in: {{number: a}}}}\n"
    workers = "{left: {stages: [a]}, right: {stages: [b, c]}}"
    with begun(tmp_path, stages, workers=workers) as run:
        messages = run["b"]
        before = next(messages)
        run.move("b", "left")
        while next(messages).header.time < before.header.time + 1_000_000_000:
            pass
    assert run.report.ok

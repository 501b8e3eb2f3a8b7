"""Replays that are paused, stepped and resumed write the same bytes as without."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from tests.commands import command
from tests.integration.gated import GATED
from tests.integration.hosts import near_agent
from tests.integration.running import STAGES, finish, start, write_graph

import followspot as fs
from followspot.control.dispatch import Request
from followspot.control.stage_status import StageStatus
from followspot.control.worker_orders import HoldSources
from followspot.operator.connect import runs_here
from followspot.operator.run_handle import RunHandle

PERIOD = 10_000_000
COUNT = 60


@pytest.fixture(scope="module")
def stages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plugins") / "gated.py"
    path.write_text(STAGES.read_text().replace("for n in range(p.count):", GATED, 1))
    return path


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """Three sources, one 3 ms later, joined; they send little until the output folder has a file `gate`."""
    return write_graph(
        tmp_path,
        f"""
a: {{uses: gated.count, with: {{count: {COUNT}}}}}
b: {{uses: gated.count, with: {{count: {COUNT}, shift: 3000000}}}}
d: {{uses: gated.count, with: {{count: {COUNT}}}}}
c: {{uses: gated.sum, in: {{numbers: [a, b, d]}}}}
w: {{uses: gated.write, in: {{number: c}}}}
""",
    )


def begun(graph: Path, stages: Path, placement: str | None, out: str) -> fs.OwnRun:
    return fs.run(graph, placement=placement, plugin_files=[stages], out=graph.parent / out)


def until(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < limit, "it never happened"
        time.sleep(0.02)


def said(*words: object) -> str:
    return command(*words, check=True).stdout


def sources(run: RunHandle) -> dict[str, StageStatus]:
    stages = (stage for worker in run.status().workers for stage in worker.stages)
    return {stage.stage: stage for stage in stages if stage.stage in "abd"}


def paused(run: RunHandle) -> bool:
    return [stage.state for stage in sources(run).values()] == ["paused"] * 3


def paused_and_stepped(run: fs.OwnRun, gates: Path) -> None:
    """Pause the run, step and resume it. gates: folder below which the output folders of all hosts are."""
    run.pause()
    for folder in (run.out, *gates.glob("*-pc-left")):
        (folder / "gate").touch()
    until(lambda: paused(run))
    before = sources(run)
    assert all(stage.fired <= 4 for stage in before.values())
    assert run.step(5, source="a") == (before["a"].fired + 4) * PERIOD
    after = sources(run)
    assert after["a"].fired == before["a"].fired + 5
    assert after["b"].time - PERIOD < after["a"].time <= after["b"].time
    assert after["d"].time == after["a"].time
    until(lambda: sources(run)["a"].idle_s > 2.0)  # a worker that hangs is killed sooner
    assert paused(run)
    assert run.step() == after["a"].time + PERIOD
    run.resume()
    assert not run.wait().errors


def undisturbed(graph: Path, stages: Path) -> bytes:
    """What the replay writes in one process without a pause."""
    with begun(graph, stages, None, "without") as run:
        (run.out / "gate").touch()
        run.wait()
    return (graph.parent / "without" / "ticks.csv").read_bytes()


@pytest.mark.parametrize("placement", [None, "stage"])
def test_a_replay_with_pauses_and_steps_writes_what_it_writes_without(
    graph: Path, stages: Path, placement: str | None
) -> None:
    with begun(graph, stages, placement, "with") as run:
        paused_and_stepped(run, graph.parent / "runs")
    written = (graph.parent / "with" / "ticks.csv").read_bytes()
    assert written == undisturbed(graph, stages)
    assert len(written.splitlines()) >= COUNT


@pytest.mark.thorough
def test_a_replay_over_hosts_is_paused_and_stepped_everywhere(
    graph: Path, stages: Path, tmp_path: Path
) -> None:
    place = tmp_path / "place.yaml"
    place.write_text("placement: p\nworkers:\n  left: {host: pc-left, stages: [a]}\n")
    agent = near_agent("pc-left", tmp_path, "--plugin", stages)
    try:
        network = fs.Network(connect=(agent.endpoint,))
        with fs.run(
            graph, placement=place, plugin_files=[stages], out=tmp_path / "with", network=network
        ) as run:
            paused_and_stepped(run, tmp_path / "runs")
    finally:
        agent.end()
    assert (tmp_path / "with" / "ticks.csv").read_bytes() == undisturbed(graph, stages)


@pytest.mark.parametrize(
    ("other", "said"), [("pause", "paused the run or made it step"), ("resume", "let the run go on")]
)
def test_a_step_ends_if_another_command_holds_the_run_or_lets_it_go_on(
    graph: Path, stages: Path, other: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It does not undo what the other command did, and does not wait for what can no longer happen."""
    with begun(graph, stages, "stage", "out") as run, ThreadPoolExecutor(1) as elsewhere:
        until(lambda: [stage.fired for stage in sources(run).values()] == [2] * 3)  # they wait for the gate
        ask, steps = run.ask, threading.Event()

        def observed(request: Request, timeout: float) -> Any:
            answer = ask(request, timeout)
            if isinstance(request, HoldSources) and request.count:
                steps.set()
            return answer

        monkeypatch.setattr(run, "ask", observed)
        stepping = elsewhere.submit(run.step, COUNT // 2, source="a")
        assert steps.wait(60.0)
        getattr(run, other)()
        with pytest.raises(fs.FollowspotError, match=f"another command has {said} meanwhile"):
            stepping.result(timeout=30.0)
        (run.out / "gate").touch()
        if other == "pause":
            until(lambda: paused(run))
            run.resume()
        assert not run.wait().errors
    assert (graph.parent / "out" / "ticks.csv").read_bytes() == undisturbed(graph, stages)


def test_a_step_beyond_the_end_ends_with_the_sources(graph: Path, stages: Path) -> None:
    with begun(graph, stages, None, "out") as run:
        run.pause()
        (run.out / "gate").touch()
        until(lambda: paused(run))
        assert run.step(10 * COUNT, source="a") <= COUNT * PERIOD
        run.resume()
        assert not run.wait().errors
    assert len((graph.parent / "out" / "ticks.csv").read_text().splitlines()) >= COUNT


@pytest.mark.parametrize(("end", "placement"), [("stop", ["--placement", "stage"]), ("Ctrl-C", [])])
def test_a_paused_run_ends_at_once_and_well(
    graph: Path, stages: Path, end: str, placement: list[str]
) -> None:
    process = start(graph, graph.parent / "out", "--plugin", str(stages), *placement)
    found: list[RunHandle] = []

    def is_there() -> bool:
        found[:] = [run for run in runs_here() if run.pid == process.pid and run.graph]
        return bool(found)

    until(is_there)
    assert "is paused" in said("pause", "--run", process.pid)
    (graph.parent / "out").mkdir(exist_ok=True)
    (graph.parent / "out" / "gate").touch()
    until(lambda: paused(found[0]))
    assert "is paused at the capture time 0.0" in said("step", "2", "--source", "b", "--run", process.pid)
    if end == "stop":
        found[0].stop()
    else:
        process.send_signal(signal.SIGINT)
    finished = finish(process, graph.parent / "out")
    assert finished.code == 0, finished.errors
    assert len(finished.lines()) < COUNT


def test_a_live_run_refuses_and_a_source_that_is_not_there_is_an_error(
    tmp_path: Path, graph: Path, stages: Path
) -> None:
    live = write_graph(tmp_path, "a: {uses: ticks.live, with: {count: 1000000}}", "live")
    with fs.run(live, plugin_files=[STAGES], out=tmp_path / "live") as run:
        for order in (run.pause, run.step):
            with pytest.raises(fs.FollowspotError, match="a live run cannot be paused: its devices"):
                order()
    with begun(graph, stages, None, "out") as run, pytest.raises(fs.FollowspotError, match='no source "c"'):
        run.step(source="c")

"""Edges that drop, within one worker: what they keep, what they count, and that replays lose nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.control.progress import Progress
from followspot.graph.compile import compile_graph
from followspot.messages import Header, Message, stamped
from followspot.operator.launch import local_run
from followspot.operator.reporting.report import RunReport
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.ledger import Ledger
from followspot.worker.wiring import RunOptions

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


class Note(Message):
    value: int


def note(time: int) -> Note:
    return stamped(Note(time), Header("a", time, time))


def execute(folder: Path, source: str, edges: str) -> tuple[RunReport, list[int]]:
    """A run in this process with an edge that drops; its report and the numbers that were written."""
    path = folder / "graph.yaml"
    path.write_text(
        f"graph: g\nstages:\n  a: {source}\n"
        "  b: {uses: ticks.add, in: {number: {from: a, policy: latest}}}\n"
        "  save: {uses: ticks.write, in: {number: {from: b, policy: drop_oldest, depth: 3}}}\n"
    )
    plan = compile_graph(path, plugin_files=[TICKS], edges=edges)  # type: ignore[arg-type]
    report = local_run(plan, RunOptions(folder)).execute()
    return report, [int(line.split(",")[2]) for line in (folder / "ticks.csv").read_text().splitlines()]


@pytest.mark.parametrize("edges", ["reference", "ring"])
def test_a_replay_loses_nothing_whatever_the_policy(tmp_path: Path, edges: str) -> None:
    report, values = execute(tmp_path, "{uses: ticks.count, with: {count: 40, size: 5000}}", edges)
    assert report.ok
    assert values == list(range(1, 41))


@pytest.mark.parametrize("edges", ["reference", "ring"])
def test_a_live_run_ends_with_every_message_accounted_for(tmp_path: Path, edges: str) -> None:
    report, values = execute(tmp_path, "{uses: ticks.live, with: {count: 40, period: 0}}", edges)
    assert report.ok
    assert values == sorted(set(values))
    assert values[-1] == 40, "the newest is never the one that is dropped"
    assert all(count.sent == count.delivered + count.dropped for _, count in report.edges)


def test_an_input_keeps_its_newest_messages_and_counts_the_others_as_dropped() -> None:
    ledger = Ledger(1)
    queue = InputQueue("edge", ledger.words, ledger.row(0), depth=100, lateness=0, keep=2)
    join = Join([JoinInput("in", joined=False, members=(queue,))], lateness=0)
    for time in range(10):
        queue.put(note(time))
    assert join.dropping == (queue,)
    queue.drop_oldest()
    assert [message.header.time for message in queue.messages] == [8, 9]
    assert ledger.count(0).dropped == 8


@pytest.mark.parametrize("edges", ["reference", "ring"])
@pytest.mark.parametrize("delay", ["", ", delay: 1"], ids=["latest", "delayed"])
def test_a_camera_that_falls_silent_does_not_hold_up_those_whose_results_it_only_samples(
    tmp_path: Path, edges: str, delay: str
) -> None:
    (tmp_path / "graph.yaml").write_text(
        "graph: g\nstages:\n"
        "  a: {uses: ticks.live, with: {count: 1000000}}\n"
        "  silent: {uses: ticks.live, with: {period: 1000}}\n"
        "  fast: {uses: ticks.add, in: {number: a}}\n"
        f"  slow: {{uses: ticks.accumulate, in: {{number: silent, before: {{from: fast{delay}}}}}}}\n"
        "  save: {uses: ticks.write, in: {number: fast}}\n"
    )
    plan = compile_graph(tmp_path / "graph.yaml", plugin_files=[TICKS], edges=edges)  # type: ignore[arg-type]
    run = local_run(plan, RunOptions(tmp_path))
    looks = iter(range(50))

    def stop(progress: Progress, expected: int | None) -> None:
        if progress.fired > 30 or next(looks, None) is None:  # the looks only bound a failure
            run.stop()

    report = run.execute(stop)
    assert report.ok
    (sampled,) = (
        count for edge, count in report.edges if edge.to_stage == "slow" and edge.to_port == "before"
    )
    assert sampled.sent > 30, "edges are full with eight"
    assert sampled.sent == sampled.delivered + sampled.dropped + sampled.unmatched

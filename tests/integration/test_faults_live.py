"""Live runs survive their workers: joins go on, dead workers restart, every message is accounted for."""

from __future__ import annotations

import json
import os
import signal
from itertools import pairwise
from pathlib import Path

import pytest
from tests.integration.running import (
    Finished,
    alive,
    balanced,
    finish,
    start,
    wait_until,
    workers,
    write_graph,
)

from followspot.operator.connect import run_here

PAIR = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
b:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
more: {uses: ticks.add, in: {number: a}}
less: {uses: ticks.add, in: {number: b}, with: {term: 1000000}}
sum:  {uses: ticks.sum, in: {numbers: [more, less]}, tolerance: 0.016}
save: {uses: ticks.write, in: {number: sum}}
"""
PLACEMENT = """
placement: cameras
workers:
  left:  {stages: [a, more]}
  right: {stages: [b, less]}
  main:  {stages: [sum, save]}
"""

SHORT = (
    PAIR.replace("[more, less]", "[more, less, short]")
    + "short: {uses: ticks.live, with: {count: 3}}\n"
    + "keep: {uses: sinks.jsonl, in: {messages: sum}}\n"
)


class Live:
    """A live run with one worker for each of two sources, and one that joins them."""

    def __init__(self, folder: Path, *options: str, stages: str = PAIR, placement: str = PLACEMENT) -> None:
        graph = write_graph(folder, stages)
        (folder / "placement.yaml").write_text(placement)
        self.out = folder / "out"
        self.process = start(graph, self.out, "--placement", str(folder / "placement.yaml"), *options)
        assert wait_until(lambda: self.lines() > 5), "the run never began"

    def lines(self) -> int:
        path = self.out / "ticks.csv"
        return len(path.read_text().splitlines()) if path.exists() else 0

    def first(self) -> str:
        """The first line; it changes when a restarted writer truncates the file."""
        return (self.out / "ticks.csv").read_text().partition("\n")[0]

    def kill_writer(self, pid: int) -> None:
        """Kill the worker that writes, and wait for the first line of its successor process."""
        first = self.first()
        os.kill(pid, signal.SIGKILL)
        assert wait_until(lambda: self.first() not in ("", first)), "its file was not begun anew"

    def last(self) -> int:
        """The number in the newest complete line."""
        return int((self.out / "ticks.csv").read_text().splitlines()[-2].split(",")[2])

    def go_on(self, count: int = 10) -> None:
        """Wait until `count` further lines are written."""
        wanted = self.lines() + count
        assert wait_until(lambda: self.lines() >= wanted), "nothing is written any more"

    def workers(self) -> list[int]:
        """Process ids of the live workers in order of start: those never restarted first, as placed."""
        return [pid for pid in workers(self.process.pid) if alive(pid)]

    def is_told(self, news: str) -> None:
        """Wait until the run has said this."""
        told = run_here(str(self.process.pid))
        assert wait_until(lambda: any(news in line for line in told.status().news)), f"never told: {news}"

    def victim(self, name: str) -> int:
        return self.workers()[["left", "right", "main"].index(name)]

    def end(self) -> Finished:
        self.process.send_signal(signal.SIGINT)
        finished = finish(self.process, self.out)
        assert finished.code == 0, finished.errors + json.dumps(finished.summary.get("errors"))
        return finished


@pytest.mark.parametrize("edges", [pytest.param("ring", marks=pytest.mark.thorough), "zenoh"])
def test_a_camera_that_is_killed_comes_back_and_the_rest_goes_on(tmp_path: Path, edges: str) -> None:
    run = Live(tmp_path, "--edges", edges)
    first = run.workers()
    os.kill(run.victim("left"), signal.SIGKILL)
    run.go_on()
    assert wait_until(lambda: len(run.workers()) == 3 and run.workers() != first), "it was not started again"
    new = (set(run.workers()) - set(first)).pop()
    before = run.lines()
    assert wait_until(lambda: joined(run.out, before)), "its numbers never came back"
    run.is_told("worker left is back")
    finished = run.end()
    assert balanced(finished.summary)
    assert any("worker left" in line and "SIGKILL" in line for line in finished.summary["warnings"])
    assert any("worker left is back" in line for line in finished.summary["warnings"])
    assert finished.edge("more.", "sum.")["lost"] <= 10
    assert finished.edge("less.", "sum.")["lost"] == 0
    assert wait_until(lambda: not any(alive(pid) for pid in [*first, new]))


def test_the_frames_of_a_run_are_counted_through_the_restarts_of_its_sources(tmp_path: Path) -> None:
    run = Live(tmp_path)
    run.go_on(50)
    first = run.workers()
    for pid in first[:2]:
        os.kill(pid, signal.SIGKILL)
    run.is_told("worker left is back")
    run.is_told("worker right is back")
    run.go_on()
    finished = run.end()
    sent = [finished.edge(*ends)["produced"] for ends in (("a.", "more."), ("b.", "less."))]
    assert finished.summary["frames"] == max(sent)


def joined(out: Path, after: int) -> bool:
    """True if a line after the first `after` is a sum of both sources, or of the left one alone."""
    lines = [line.split(",") for line in (out / "ticks.csv").read_text().splitlines()[after:]]
    values = [int(line[2]) for line in lines if len(line) == 4]
    return any(value < 1_000_000 for value in values) or any(b - a > 1 for a, b in pairwise(values))


@pytest.mark.thorough
def test_the_worker_that_joins_over_zenoh_is_killed_and_tracks_go_on(tmp_path: Path) -> None:
    run = Live(tmp_path, "--edges", "zenoh")
    run.kill_writer(run.victim("main"))
    run.go_on()
    finished = run.end()
    assert balanced(finished.summary)
    assert all(0 <= edge["lost"] <= 10 for edge in finished.summary["edges"])


def test_after_the_end_of_a_camera_file_other_workers_are_still_restarted(tmp_path: Path) -> None:
    run = Live(tmp_path, stages=SHORT, placement=PLACEMENT + "  short: {stages: [short]}\n")
    assert wait_until(lambda: len(run.workers()) == 3), "the short one has not ended"
    _, right, main = run.workers()
    kept = run.out / "messages.jsonl"
    assert wait_until(lambda: kept.stat().st_size > 0), "nothing was flushed"
    before = kept.read_text().splitlines()
    run.kill_writer(main)
    run.go_on()
    os.kill(right, signal.SIGSTOP)
    assert wait_until(lambda: not alive(right)), "it was not noticed"
    assert wait_until(lambda: run.last() < 1_000_000), "the left one is alone"
    assert wait_until(lambda: run.last() > 1_000_000), "the right one is not back"
    left, _, right = run.workers()
    for camera in (left, right):
        os.kill(camera, signal.SIGTERM)  # it ends as if its stream had
    finished = finish(run.process, run.out)
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert balanced(finished.summary)
    assert any("worker right" in line and "hangs" in line for line in finished.summary["warnings"])
    assert finished.edge("short.", "sum.")["delivered"] <= 3
    after = kept.read_text().splitlines()
    assert after[: len(before)] == before, "what a sink wrote before its worker died was lost"
    assert json.loads(after[-1])["time"] > json.loads(before[-1])["time"]
    assert all(0 <= edge["lost"] <= 10 for edge in finished.summary["edges"])


def test_a_replay_fails_when_a_worker_dies_unless_told_to_restart(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.count, with: {count: 400}}
b:    {uses: ticks.accumulate, in: {number: a, before: {from: c, delay: 1}}}
c:    {uses: ticks.add, in: {number: b}, with: {sleep: 0.002}}
save: {uses: ticks.write, in: {number: c}}
""",
    )
    out = tmp_path / "out"
    placement = "placement: two\nworkers:\n  source: {stages: [a, b]}\n  rest: {stages: [c, save]}\n"
    (tmp_path / "placement.yaml").write_text(placement)
    process = start(graph, out, "--placement", str(tmp_path / "placement.yaml"), "--restart")
    assert wait_until(lambda: (out / "ticks.csv").exists() and (out / "ticks.csv").stat().st_size > 0)
    os.kill(workers(process.pid)[0], signal.SIGKILL)  # its source starts again, and b waits for feedback
    finished = finish(process, out)
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert balanced(finished.summary)
    numbers = [int(line.split(",")[0]) for line in finished.lines()]
    assert numbers == sorted(numbers)
    assert numbers[-1] == 399
    assert len(numbers) >= 380

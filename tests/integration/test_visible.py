"""Absent hosts and workers show as absent in `top`, page, metrics, progress and exit code."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest
from tests.commands import command
from tests.integration.hosts import Agent, near_agent
from tests.integration.running import STAGES, Finished, finished, start, wait_until, workers, write_graph
from tests.tools.page.bundled import bundle

from followspot.operator.attach import Attachment, attached_run
from followspot.operator.remote import remote_host
from followspot.transport.zenoh.network import Network

LIVE = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.03}}
b:    {uses: ticks.live, with: {count: 1000000, period: 0.03}}
sum:  {uses: ticks.sum, in: {numbers: [a, b]}, tolerance: 0.012}
save: {uses: ticks.write, in: {number: sum}}
"""
HERE = "workers:\n  left: {stages: [a]}\n  right: {stages: [b, sum, save]}\n"
THERE = HERE.replace("left: {", "left: {host: pc-left, ")
PATIENCE = 60.0


class Watched:
    """A live run in two workers, as its observers see it."""

    def __init__(self, folder: Path, placement: str, *options: str, stages: str = LIVE) -> None:
        bundle()
        self.out = folder / "out"
        graph = write_graph(folder, stages)
        (folder / "two.yaml").write_text(placement)
        where = ("--placement", str(folder / "two.yaml"), "--dashboard-at", "127.0.0.1:0")
        self.process = start(graph, self.out, *where, *options)
        self.said: list[str] = []
        line = self.process.stderr.readline()
        found = re.search(r"http://\S+/", line)
        assert found, line + self.process.stderr.read()
        self.url = found[0]
        self.listener = threading.Thread(target=lambda: self.said.extend(self.process.stderr), daemon=True)
        self.listener.start()

    def looked(self, *words: str) -> subprocess.CompletedProcess[str]:
        """The output of a command that reads the run."""
        return command(*words, timeout=PATIENCE)

    def top(self) -> dict[str, Any]:
        """The output of `followspot top` as data."""
        done = self.looked("top", "--run", str(self.process.pid), "--json")
        assert done.returncode == 0, done.stderr
        return dict(json.loads(done.stdout))

    def status(self) -> dict[str, Any]:
        """The status that the page gets."""
        return dict(json.load(urlopen(self.url + "status", timeout=PATIENCE)))

    def metrics(self) -> dict[str, str]:
        text = urlopen(self.url + "metrics", timeout=PATIENCE).read().decode()
        return dict(re.findall(r"^([a-z_]+(?:\{.*\})?) (\S+)$", text, re.MULTILINE))

    def until(self, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The first status of the page that fits."""
        told: list[dict[str, Any]] = []

        def looks() -> bool:
            told[:] = [self.status()]
            return fits(told[0])

        assert wait_until(looks, PATIENCE), told
        return told[0]

    def until_fault(self, pattern: str) -> dict[str, Any]:
        """The first status of the page whose first fault is such a one; on a busy machine others may come."""
        return self.until(lambda told: any(re.fullmatch(pattern, line) for line in told["faults"][:1]))

    def ended(self) -> Finished:
        self.process.send_signal(signal.SIGINT)
        summary = self.process.stdout.read()
        self.listener.join(PATIENCE)
        return finished(self.process.wait(PATIENCE), summary, "".join(self.said), self.out)


@pytest.fixture
def agent(tmp_path: Path) -> Iterator[Agent]:
    home = tmp_path / "pc-left"
    home.mkdir()
    made = near_agent("pc-left", home)
    yield made
    made.process.kill()
    made.process.communicate()


@contextmanager
def watched(folder: Path, placement: str, *options: str, stages: str = LIVE) -> Iterator[Watched]:
    run = Watched(folder, placement, *options, stages=stages)
    try:
        yield run
    finally:
        run.process.kill()
        run.process.wait()


def all_over(attachment: Attachment) -> bool:
    return all(worker.phase == "over" for worker in attachment.coordinator.status().workers)


@pytest.mark.thorough
def test_an_observer_restarts_nothing_after_the_end_of_a_run(
    tmp_path: Path, agent: Agent, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote_host, "_RESUME_TIMEOUT", 1.0)
    with watched(tmp_path, HERE, "--host", "pc-left", "--connect", agent.endpoint) as run:
        run.until(lambda told: told["fired"] > 20)
        with attached_run(Network(connect=(agent.endpoint,)), "graph") as looking:
            assert run.ended().code == 0
            assert wait_until(lambda: all_over(looking), PATIENCE)
            assert workers(agent.process.pid) == []


def states(run: dict[str, Any]) -> dict[str, str]:
    return {stage["stage"]: stage["state"] for stage in run["stages"]}


def fired(run: dict[str, Any]) -> dict[str, int]:
    return {stage["stage"]: stage["fired"] for stage in run["stages"]}


def test_a_dead_host_is_absent_in_top_page_and_metrics(tmp_path: Path, agent: Agent) -> None:
    """The host is heard of every 0.2 s only, and `sum` does not wait for it: its own count must be there."""
    with watched(tmp_path, THERE, "--connect", agent.endpoint) as run:
        well = run.until(lambda told: told["fired"] > 20 and fired(told)["a"] > 0 and not told["faults"])
        assert "absent" not in states(well).values()
        agent.process.kill()
        absent = r"host pc-left is absent: last heard \d+ s ago"
        for seen in (run.until_fault(absent), run.top()):
            assert re.fullmatch(absent, seen["faults"][0])
            (left,) = [worker for worker in seen["workers"] if worker["worker"] == "left"]
            assert (left["host"], left["phase"]) == ("pc-left", "absent")
            (a,) = [stage for stage in seen["stages"] if stage["stage"] == "a"]
            assert (a["state"], a["rate"], a["load"]) == ("absent", None, None)
            assert a["age_s"] > 1.0
            assert a["fired"] > 0  # the last that is known
            assert {"sum", "save", "b"} <= {s for s, state in states(seen).items() if state != "absent"}
        assert wait_until(
            lambda: any("! host pc-left is absent: last heard" in line for line in run.said), PATIENCE
        )
        ended = run.ended()
    assert ended.code == 1, ended.errors
    why = "worker left was not there at the end: host pc-left does not answer"
    assert ended.summary["errors"] == [why]
    assert {w["worker"]: w["absent"] for w in ended.summary["workers"]} == {"left": True, "right": False}


def test_an_absent_worker_at_the_end_is_an_error(tmp_path: Path) -> None:
    """The worker cannot restart, because its plugin is broken by then."""
    plugin = tmp_path / "brittle.py"
    shutil.copy(STAGES, plugin)
    stages = LIVE.replace("ticks.", "brittle.")
    with watched(tmp_path, HERE, "--plugin", str(plugin), stages=stages) as run:
        run.until(lambda told: told["fired"] > 20 and not told["faults"])
        plugin.write_text("raise RuntimeError('broken meanwhile')")
        os.kill(workers(run.process.pid)[0], signal.SIGKILL)
        told = run.until_fault(r"worker left is absent: last heard \d+ s ago")
        assert states(told)["a"] == "absent"
        ended = run.ended()
    assert ended.code == 1, ended.errors
    assert any("worker left was not there at the end" in line for line in ended.summary["errors"])


@pytest.mark.thorough
def test_a_run_with_a_suspended_operator_is_old_not_over(tmp_path: Path) -> None:
    with watched(tmp_path, HERE) as run:
        run.until(lambda told: told["fired"] > 20 and not told["faults"])
        run.process.send_signal(signal.SIGSTOP)
        told = run.until_fault(r"the run has not answered for \d+ s")
        assert set(states(told).values()) == {"old"}
        assert told["rate"] is None
        top = run.looked("top", "--run", str(run.process.pid))
        assert top.returncode == 1
        assert f"process {run.process.pid} is suspended; kill -CONT {run.process.pid}" in top.stderr
        run.process.send_signal(signal.SIGCONT)
        run.until(lambda told: not told["faults"] and "old" not in states(told).values())
        ended = run.ended()
    assert ended.code == 0, ended.errors

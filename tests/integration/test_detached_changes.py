"""Moves and swaps of a run under agents alone; the command that leads one may die between two hosts."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.commands import command, launch
from tests.integration.hosts import Agent, near_agent
from tests.integration.running import STAGES, balanced, start, wait_until, write_graph

GRAPH = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
hall: {graph: one.yaml, in: {number: a}}
b:    {uses: ticks.tally, in: {number: hall}, with: {step: 3}}
save: {uses: ticks.write, in: {number: b}}
c:    {uses: ticks.tally, in: {number: b}}
more: {uses: ticks.write, in: {number: c}, with: {path: more.csv}}
"""
PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, stages: [a, hall, b]}
  right: {host: pc-right, stages: [save, c, more]}
"""
ONE = """
inputs: {number: t.number}
outputs: {number: t}
stages: {t: {uses: ticks.add, with: {term: 1000}}}
"""
TWO = """
inputs: {number: t.number}
outputs: {number: u}
stages:
  t: {uses: ticks.add, with: {term: 2000}}
  u: {uses: ticks.add, in: {number: t}, with: {term: 3000}}
"""
"""Other files in the place of `hall`."""
DYING = """
import os, signal, sys
from followspot.operator.attach import attached_run, handle_of
from followspot.operator.change_under_way import ChangeUnderWay
from followspot.plugins.registry import use_plugin_files
from followspot.transport.zenoh.network import Network

class DiesAt(ChangeUnderWay):
    def wait_for(self, what):
        if what == sys.argv[1]:
            os.kill(os.getpid(), signal.SIGKILL)

use_plugin_files([sys.argv[3]])
network = Network(connect=tuple(sys.argv[5:]))
with attached_run(network, sys.argv[4]) as attachment:
    attachment.coordinator.change = DiesAt()
    run = handle_of(attachment, network)
    run.move(["b"], "pc-right") if sys.argv[2] == "move" else run.change(sys.argv[2].split())
"""
"""Moves `b` or changes stages, and kills itself when it would wait for what its first argument says."""


class Detached:
    """A detached run under two agents."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.agents: list[Agent] = []
        for name in ("pc-left", "pc-right"):
            (folder / name).mkdir()
            self.agents.append(near_agent(name, folder / name, *self.connect))
        for name, text in (("hosts", PLACEMENT), ("one", ONE), ("two", TWO)):
            (folder / f"{name}.yaml").write_text(text)
        graph = write_graph(folder, GRAPH)
        options = ("--placement", str(folder / "hosts.yaml"), "--detach", *self.connect)
        stdout, stderr = start(graph, folder / "out", *options).communicate(timeout=60)
        assert stdout, stderr
        self.name = json.loads(stdout)["run"]

    @property
    def connect(self) -> list[str]:
        """Options that lead to the agents."""
        return [word for agent in self.agents for word in ("--connect", agent.endpoint)]

    def dies(self, change: str, at: str) -> None:
        """Begin a "move" of `b`, or a change; the command is killed when it would wait for `at`."""
        words = [at, change, str(STAGES), self.name, *(agent.endpoint for agent in self.agents)]
        script = [sys.executable, "-c", DYING, *words]
        done = subprocess.run(script, check=False, timeout=60, cwd=self.folder)
        assert done.returncode == -signal.SIGKILL

    def command(self, *words: str) -> str:
        """What a command about the run says."""
        done = command(words[0], "--run", self.name, *words[1:], *self.connect)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def move(self, place: str) -> None:
        """Move `b`."""
        self.command("move", "b", place, "--plugin", str(STAGES))

    def attach_says(self) -> str:
        """The second line of `followspot attach`; the first says where the run is."""
        with launch("attach", "--run", self.name, *self.connect) as watching:
            lines = [watching.stderr.readline().rstrip() for _ in range(2)]
            watching.kill()
        return lines[1]

    def faults(self) -> list[str]:
        """The faults that `followspot top` shows."""
        found: list[str] = json.loads(self.command("top", "--json"))["faults"]
        return found

    def values(self) -> list[int]:
        """What was written."""
        lines = [line for path in self.folder.glob("pc-right/runs/*/ticks.csv") for line in path.open()]
        return [int(fields[2]) for line in lines if len(fields := line.split(",")) == 4]

    def grows(self) -> list[int]:
        """Wait for ten new values; these."""
        before = len(self.values())
        assert wait_until(lambda: len(self.values()) > before + 10, 40.0)
        return self.values()[before:]


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Detached]:
    made = Detached(tmp_path)
    yield made
    for agent in made.agents:
        agent.process.kill()
        agent.process.communicate()


def test_a_stage_that_comes_back_to_a_host_has_its_newest_state(run: Detached) -> None:
    for place in ("pc-right", "pc-left", "pc-right"):
        last = run.grows()[-1]
        run.move(place)
        assert run.grows()[0] > last


@pytest.mark.parametrize("place", ["pc-left", pytest.param("pc-right", marks=pytest.mark.thorough)])
def test_after_a_move_that_died_the_next_brings_all_hosts_to_one_plan(run: Detached, place: str) -> None:
    begun = run.grows()
    run.dies("move", "host pc-left to take the new plan")
    (fault, *_) = run.faults()
    assert "by that of pc-left, b is in worker left" in fault
    assert "by that of pc-right, b is in worker right" in fault
    assert fault.endswith("the next move, swap or set of the run brings all hosts to one plan first")
    assert run.attach_says() == f"followspot: {fault}"
    run.move(place)
    values = run.grows()
    assert values[0] > begun[-1], "it counts on"
    assert values[1] - values[0] == 3, "with its parameters"
    assert run.faults() == []


def test_a_set_that_died_names_the_host_that_lacks_it(run: Detached) -> None:
    run.grows()
    run.dies("b.step=7 c.step=9", "host pc-right to let the new stages take over")
    values = run.grows()[-2:]
    assert values[1] - values[0] == 7, "the other host has it"
    (fault,) = run.faults()
    assert fault.startswith("host pc-right built new stages that have not taken over")
    assert fault.endswith("if this stays, repeat the change")


def test_after_a_swap_that_died_the_next_change_brings_all_hosts_to_one_plan(run: Detached) -> None:
    begun = run.grows()
    run.dies("hall=two.yaml", "host pc-right to take the new plan")
    (fault, *_) = run.faults()
    assert "by that of pc-left, hall/u is in worker left; by that of pc-right, hall/u is absent" in fault
    assert "hall/u: term = 7" in run.command("set", "hall/u.term=7", "--plugin", str(STAGES))
    assert run.grows()[0] > begun[-1], "it counts on"
    assert run.faults() == []
    assert balanced(json.loads(run.command("attach", "--stop", "--json")))

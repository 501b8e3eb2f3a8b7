"""Moves of a run under agents alone."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.commands import command
from tests.integration.hosts import Agent, near_agent
from tests.integration.running import STAGES, start, wait_until, write_graph

GRAPH = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
hall: {graph: one.yaml, in: {number: a}}
b:    {uses: ticks.tally, in: {number: hall}, with: {step: 3}}
save: {uses: ticks.write, in: {number: b}}
"""
PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, stages: [a, hall, b]}
  right: {host: pc-right, stages: [save]}
"""
ONE = """
inputs: {number: t.number}
outputs: {number: t}
stages: {t: {uses: ticks.add, with: {term: 1000}}}
"""


class Detached:
    """A detached run under two agents."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.agents: list[Agent] = []
        for name in ("pc-left", "pc-right"):
            (folder / name).mkdir()
            self.agents.append(near_agent(name, folder / name, *self.connect))
        for name, text in (("hosts", PLACEMENT), ("one", ONE)):
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

    def command(self, *words: str) -> str:
        """What a command about the run says."""
        done = command(words[0], "--run", self.name, *words[1:], *self.connect)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def move(self, place: str) -> None:
        """Move `b`."""
        self.command("move", "b", place, "--plugin", str(STAGES))

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

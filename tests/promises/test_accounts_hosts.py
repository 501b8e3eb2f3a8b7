"""The ledger tells the truth on several hosts: agents die and come back, cables are cut, stages move."""

from __future__ import annotations

import os
import random
import signal
import uuid
from collections.abc import Callable
from pathlib import Path

from books import impossible
from hosts import Agent, free_port, near_agent
from journaled import STAGES, Journaled
from running import start, write_graph

LIVE = """
cam:  {uses: journal.camera}
step: {uses: journal.step, in: {note: cam}}
near: {uses: journal.camera}
look: {uses: journal.sampling, in: {note: near, known: {from: both, delay: 1}}}
far:  {uses: journal.sampling, in: {note: step, known: {from: both, delay: 1}}}
both: {uses: journal.meet, in: {notes: [far, look]}, tolerance: 0.005}
save: {uses: journal.save, in: {note: both}, on_error: skip}
"""
PLACEMENT = """
placement: hosts
workers:
  eye:   {host: pc-left, stages: [cam]}
  left:  {host: pc-left, stages: [step, far]}
  main:  {stages: [near, look]}
  last:  {stages: [both, save]}
"""
WORKERS = {"eye": "cam", "left": "step", "main": "near", "last": "save"}


class Near(Journaled):
    """A live run of this process and an agent, which are one host in truth."""

    def __init__(self, folder: Path) -> None:
        super().__init__(f"accounts-{uuid.uuid4().hex[:8]}", folder / "books", folder / "out", WORKERS)
        self.folder.mkdir()
        os.environ["BOOKS"] = str(self.folder)
        self.root = folder
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.agent = self._agent()
        (folder / "placement.yaml").write_text(PLACEMENT)
        words = ("--plugin", str(STAGES), "--placement", str(folder / "placement.yaml"))
        graph = write_graph(folder, LIVE, self.name)
        self.process = start(graph, self.out, *words, "--connect", self.endpoint)

    def parents(self) -> list[int]:
        return [self.process.pid, self.agent.process.pid]

    def __exit__(self, *found: object) -> None:
        super().__exit__(*found)
        self.agent.process.kill()
        self.agent.process.communicate()

    def kill_agent(self) -> None:
        self.agent.process.kill()
        self.agent.process.communicate()
        self.goes_on("near", count=30)
        self.agent = self._agent()

    def stop_agent(self) -> None:
        """Until the operator misses it."""
        self.agent.signal(signal.SIGSTOP)
        self.goes_on("near", count=200)
        self.agent.signal(signal.SIGCONT)

    def _agent(self) -> Agent:
        return near_agent("pc-left", self.root, "--plugin", STAGES, at=self.endpoint)


def befall(run: Near, chance: random.Random, faults: int) -> None:
    """Faults one after the other, some of them while the last one is not over yet."""
    workers = list(WORKERS)
    kinds: list[Callable[[], None]] = [
        run.kill_agent,
        run.stop_agent,
        lambda: run.kill(chance.choice(workers)),
        lambda: run.hang(chance.choice(workers)),
    ]
    for _ in range(faults):
        with run.asked(*chance.choice([("slow", "step"), ("slow", "save"), ("full", "save")])):
            chance.choice(kinds)()
        if chance.random() < 0.7:
            run.goes_on()


def test_journals_agree_with_the_ledger_of_two_hosts(tmp_path: Path) -> None:
    with Near(tmp_path) as run:
        run.goes_on()
        run.kill("left")
        run.kill_agent()
        run.goes_on()
        assert not list(impossible(run.status()))
        run.judge(run.end())

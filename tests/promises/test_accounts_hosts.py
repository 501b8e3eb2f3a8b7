"""The ledger tells the truth on several hosts: agents die and come back, cables are cut, stages move."""

from __future__ import annotations

import os
import random
import signal
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.commands import launch
from tests.integration.hosts import Agent, Hosts, free_port, namespaces_are_permitted, near_agent
from tests.integration.running import Finished, alive, finish, start, wait_until, write_graph
from tests.promises.journaled import FOREVER, STAGES, Journaled
from tests.promises.ledger_check import impossible, journals_of

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


class TwoHosts(Journaled):
    """A live run of this process and an agent."""

    agent: Agent

    def __init__(self, folder: Path) -> None:
        super().__init__(f"accounts-{uuid.uuid4().hex[:8]}", folder / "journals", folder / "out", WORKERS)
        self.folder.mkdir()
        os.environ["JOURNALS"] = str(self.folder)
        self.root = folder
        placement = folder / "placement.yaml"
        placement.write_text(PLACEMENT)
        self.graph = write_graph(folder, LIVE, self.name)
        self.words = ("--plugin", str(STAGES), "--placement", str(placement))

    def parents(self) -> list[int]:
        return [self.process.pid, self.agent.process.pid]

    def __exit__(self, *found: object) -> None:
        super().__exit__(*found)
        self.agent.process.kill()
        self.agent.process.communicate()

    def kill_agent(self) -> None:
        self.agent.process.kill()
        self.agent.process.wait()  # a worker that hangs has its pipes open still
        self.goes_on("near", count=30)
        self.agent = self.new_agent()

    def kill_agent_of_one_that_hangs(self, worker: str) -> None:
        """Nobody is left who would end the worker but the agent that comes next."""
        pid = self.signal(worker, signal.SIGSTOP)
        self.kill_agent()
        assert wait_until(lambda: not alive(pid), FOREVER), "two count what one stage does"
        self.killed.add(pid)

    def move(self, stage: str, place: str) -> None:
        """As an operator does."""
        self.told("move", "--run", self.name, stage, place)

    def stop_agent(self) -> None:
        """Until the operator misses it."""
        self.agent.signal(signal.SIGSTOP)
        self.goes_on("near", count=200)
        self.agent.signal(signal.SIGCONT)

    def new_agent(self) -> Agent:
        raise NotImplementedError


class Near(TwoHosts):
    """On one host in truth."""

    def __init__(self, folder: Path, *options: str) -> None:
        super().__init__(folder)
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.agent = self.new_agent()
        self.process = start(self.graph, self.out, *self.words, "--connect", self.endpoint, *options)

    def new_agent(self) -> Agent:
        return near_agent("pc-left", self.root, "--plugin", STAGES, at=self.endpoint)


class Apart(TwoHosts):
    """In two network namespaces, joined by a cable that can be pulled."""

    def __init__(self, hosts: Hosts) -> None:
        super().__init__(hosts.folder)
        self.hosts = hosts
        self.agent = self.new_agent()
        where = ("--connect", hosts.endpoint("pc-left"), "--insecure", "--out", str(self.out), "--json")
        self.process = hosts.start("desk", "run", self.graph, *self.words, *where)

    def told(self, *words: str) -> str:
        asked = self.hosts.start("desk", *words)
        said, errors = asked.communicate(timeout=FOREVER)
        assert asked.returncode == 0, errors
        return said

    def new_agent(self) -> Agent:
        return self.hosts.agent("pc-left", "--plugin", STAGES)

    def cut(self, count: int) -> None:
        """Pull the cable while the camera at the desk makes so many pictures."""
        self.hosts.link("pc-left", "down")
        self.goes_on("near", count=count)
        self.hosts.link("pc-left", "up")


def befall(run: TwoHosts, chance: random.Random, faults: int) -> None:
    """Faults one after the other, some of them while the last one is not over yet."""
    workers = list(WORKERS)
    kinds: list[Callable[[], None]] = [
        run.kill_agent,
        run.stop_agent,
        lambda: run.kill(chance.choice(workers)),
        lambda: run.hang(chance.choice(workers)),
    ]
    if isinstance(run, Apart):
        kinds += [lambda: run.cut(chance.choice([20, 100, 300]))] * 4
    for _ in range(faults):
        with run.asked(*chance.choice([("slow", "step"), ("slow", "save"), ("full", "save")])):
            chance.choice(kinds)()
        if chance.random() < 0.7:
            run.goes_on()


def test_journals_agree_with_the_ledger_of_two_hosts(tmp_path: Path) -> None:
    with Near(tmp_path) as run:
        run.goes_on()
        run.kill("main")
        run.kill_agent_of_one_that_hangs("left")
        run.goes_on()
        assert not list(impossible(run.status()))
        run.judge(run.end())


@pytest.mark.thorough
def test_a_host_that_never_comes_back_leaves_no_column_below_zero(tmp_path: Path) -> None:
    with Near(tmp_path) as run:
        run.goes_on()
        run.agent.process.kill()
        run.agent.process.wait()
        run.goes_on("near", "look", count=300)
        assert not list(impossible(run.status()))
        finished = run.end()
        assert finished.code == 1
        assert any("pc-left" in line for line in finished.summary["errors"])
        edges = finished.summary["edges"]
        assert not list(impossible(edges))
        here = [edge for edge in edges if edge["from"] in ("near.out", "look.out", "both.out")]
        journals = journals_of(run.folder, finished.summary["warnings"])
        for edge in here:
            assert edge["produced"] == len(journals.of(edge["from"].partition(".")[0], "out.out")), edge


class Detached(Near):
    """All of it under the agent, without its operator."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "--detach", "--host", "pc-left")
        finished = finish(self.process, self.out)
        assert finished.code == 0, finished.errors

    def parents(self) -> list[int]:
        return [self.agent.process.pid]

    def end(self) -> Finished:
        said = launch("attach", "--run", self.name, "--stop", "--json", "--connect", self.endpoint)
        return finish(said, self.out)


@pytest.mark.thorough
def test_journals_agree_with_the_ledger_of_a_run_that_agents_take_up_again_by_themselves(
    tmp_path: Path,
) -> None:
    with Detached(tmp_path) as run:
        run.goes_on()
        run.kill("left")
        run.goes_on()
        wait_until(lambda: bool(list(tmp_path.glob("runs/*/.order"))), FOREVER)
        run.agent.process.kill()
        run.agent.process.wait()
        run.agent = run.new_agent()
        run.goes_on()
        run.judge(run.end())


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(6))
def test_journals_agree_with_the_ledger_of_stages_that_move_between_hosts(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    with Near(tmp_path) as run:
        for _ in range(4):
            run.goes_on()
            run.move(chance.choice(["step", "far", "look"]), chance.choice(["eye", "main"]))
            run.goes_on()
            befall(run, chance, 1)
        run.goes_on()
        assert not list(impossible(run.status()))
        run.judge(run.end())


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    if not namespaces_are_permitted():
        pytest.skip("this user may not make network namespaces")
    with Hosts(tmp_path, ["desk", "pc-left"]) as made:
        yield made


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(6))
def test_journals_agree_with_the_ledger_of_hosts_whose_cable_is_pulled(hosts: Hosts, seed: int) -> None:
    chance = random.Random(seed)
    with Apart(hosts) as run:
        run.goes_on()
        for _ in range(2):
            befall(run, chance, 3)
            assert not list(impossible(run.status()))
        run.goes_on()
        run.judge(run.end())

"""A live run on two hosts with a stream each way, and the faults between them."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.integration.hosts import Agent, Hosts
from tests.integration.running import STAGES, Finished, finish, wait_until, workers, write_graph

GRAPH = """
there: {uses: ticks.live, with: {count: 1000000, period: 0.02}}
come:  {uses: ticks.write, in: {number: there}, with: {path: come.csv}}
here:  {uses: ticks.live, with: {count: 1000000, period: 0.02}}
go:    {uses: ticks.write, in: {number: here}, with: {path: go.csv}}
"""
PLACEMENT = """
placement: two
workers:
  left:  {host: pc-left, stages: [there, go]}
  right: {stages: [here, come]}
"""
NAMES = ("desk", "pc-left", "middle")
_FLOWS = 5
"""Number of messages each way that shows that a host takes part."""
FAULTS = (
    "cable",
    "router's cable",
    "router",
    "deaf desk",
    "deaf host",
    "operator suspended",
    "desk suspended",
    "agent suspended",
    "host suspended",
)
"""The faults of `Pair.away`."""


class Pair:
    """The operator's host, a host with an agent, and a run on both."""

    def __init__(self, hosts: Hosts, *, routed: bool = False, agent: tuple[str, ...] = ()) -> None:
        """routed: whether they connect through a router; agent: further options of the agent."""
        self.hosts = hosts
        self.out = hosts.folder / "out"
        self._at = f"tcp/{hosts.address('middle')}:7447" if routed else ""
        self._router = self._routing() if routed else None
        self._options = ("--plugin", STAGES, *agent)
        self.agent = self.new_agent()
        graph = write_graph(hosts.folder, GRAPH)
        placement = hosts.folder / "two.yaml"
        placement.write_text(PLACEMENT)
        there = ("--router", self._at) if routed else ("--connect", hosts.endpoint("pc-left"))
        words = ("run", graph, "--placement", placement, "--plugin", STAGES, "--out", self.out)
        self.desk = hosts.start("desk", *words, "--json", "--quiet", "--insecure", *there)

    def new_agent(self) -> Agent:
        """Start an agent."""
        return self.hosts.agent("pc-left", *self._options, router=self._at)

    def flows(self, seconds: float = 90.0) -> float:
        """Wait until new messages flow both ways; return the time it took, s."""
        begun, before = time.monotonic(), self._written()
        assert wait_until(lambda: self._grew(before), seconds), (before, self._written())
        return time.monotonic() - begun

    @contextmanager
    def away(self, fault: str) -> Iterator[None]:
        """Keep up a fault between the hosts while the block runs."""
        if fault == "router":
            assert self._router is not None
            self._router.kill()
            self._router.communicate()
            yield
            self._router = self._routing()
        elif fault.endswith("suspended"):
            first = self.desk.pid if fault.startswith(("operator", "desk")) else self.agent.process.pid
            stopped = [first, *(workers(first) if fault.startswith(("desk", "host")) else ())]
            self._signal(stopped, signal.SIGSTOP)
            yield
            self._signal(stopped, signal.SIGCONT)
        elif fault.startswith("deaf"):
            name = {"deaf desk": "desk", "deaf host": "pc-left"}[fault]
            self.hosts.deafen(name, True)
            yield
            self.hosts.deafen(name, False)
        else:
            name = {"cable": "pc-left", "router's cable": "middle"}[fault]
            self.hosts.link(name, "down")
            yield
            self.hosts.link(name, "up")

    def host_noted(self, line: str) -> bool:
        """True once the host's log of the run has this line; False after a timeout."""
        return wait_until(lambda: host_noted(self.hosts, line), 60.0)

    def desk_noted(self, line: str) -> bool:
        """True once the operator's log of the run has this line; False after a timeout."""
        log = self.out / "log.jsonl"
        return wait_until(lambda: log.exists() and line in log.read_text(), 60.0)

    def host_is_idle(self, seconds: float = 60.0) -> bool:
        """True once the host has no worker; False after `seconds`."""
        return wait_until(lambda: not workers(self.agent.process.pid), seconds)

    def ended(self) -> Finished:
        """End the run by Ctrl-C."""
        self.desk.send_signal(signal.SIGINT)
        return finish(self.desk, self.out)

    def _routing(self) -> subprocess.Popen[str]:
        return self.hosts.start("middle", "router", "--listen", self._at, "--insecure")

    def _written(self) -> tuple[int, int]:
        """Numbers of lines written on the operator's host and on the other."""
        far = self.hosts.folder.glob("runs/*-pc-left/go.csv")
        return _lines(self.out / "come.csv"), sum(map(_lines, far))

    def _grew(self, before: tuple[int, int]) -> bool:
        return all(now >= then + _FLOWS for now, then in zip(self._written(), before, strict=True))

    @staticmethod
    def _signal(pids: list[int], number: signal.Signals) -> None:
        for pid in pids:
            os.kill(pid, number)


def host_noted(hosts: Hosts, line: str) -> bool:
    """True if the log of a run on pc-left has this line."""
    return any(line in log.read_text() for log in hosts.folder.glob("runs/*-pc-left/log.jsonl"))


def _lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0

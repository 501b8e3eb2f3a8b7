"""Two agents on this host, and a live graph with one source on each."""

from __future__ import annotations

import signal
from pathlib import Path

from tests.commands import Started
from tests.integration.hosts import Agent, free_port, near_agent
from tests.integration.live_sum import LIVE
from tests.integration.running import Finished, finish, start, write_graph

PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, stages: [a, more]}
  right: {host: pc-right, stages: [b, less]}
"""
HOSTS = ("pc-left", "pc-right")


class TwoAgents:
    """Two agents on this host, and a live graph with one source on each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.graph = write_graph(folder, LIVE)
        (folder / "hosts.yaml").write_text(PLACEMENT)
        self.agents: dict[str, Agent] = {}
        self.endpoints = {name: f"tcp/127.0.0.1:{free_port()}" for name in HOSTS}
        self.connect = [word for endpoint in self.endpoints.values() for word in ("--connect", endpoint)]

    def agent(self, name: str) -> Agent:
        home = self.folder / name
        home.mkdir(exist_ok=True)
        others = [word for other in HOSTS if other != name for word in ("--connect", self.endpoints[other])]
        self.agents[name] = near_agent(name, home, *others, at=self.endpoints[name])
        return self.agents[name]

    def begin(self, *options: str) -> Started:
        placement = ("--placement", str(self.folder / "hosts.yaml"))
        return start(self.graph, self.folder / "out", *placement, *self.connect, *options)

    def close(self) -> None:
        for agent in self.agents.values():
            agent.process.kill()
            agent.process.communicate()


def ended(process: Started, out: Path) -> Finished:
    process.send_signal(signal.SIGINT)
    return finish(process, out)

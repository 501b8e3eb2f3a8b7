"""The show of tools/soak.py: hosts, agents, a router and a live run in network namespaces, and its faults."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from hosts import Agent, Hosts  # type: ignore[import-not-found]  # noqa: E402
from running import children  # type: ignore[import-not-found]  # noqa: E402

from soak_stages import CLOCK  # noqa: E402

__all__ = ["FAULTS", "SIDES", "Hosts", "Show", "children"]

STAGES = ROOT / "tools" / "soak_stages.py"
SIDES = ("pc-left", "pc-right")
GRAPH = """
graph: soak
stages:
  left:  {uses: soak_stages.heart, with: {side: 0}}
  right: {uses: soak_stages.heart, with: {side: 1}}
  file:  {uses: soak_stages.heart, with: {side: 2, count: 300}}
  meet:  {uses: soak_stages.meet, in: {beats: [left, right, file]}, tolerance: 0.006, on_error: skip}
"""
PLACEMENT = """
placement: soak
workers:
  left:  {host: pc-left, stages: [left, file]}
  right: {host: pc-right, stages: [right]}
"""
CUT_S = 2.5
"""Seconds for which cables are pulled and agents stopped: longer than a peer may be silent."""
_DISK = 4 << 20
"""Bytes of the disk that the run writes to."""


class Show:
    """Everything that runs: a router, two agents, a run; what can be seen of it, and what can befall it."""

    def __init__(self, hosts: Hosts, chance: random.Random) -> None:
        self.hosts = hosts
        self.folder = hosts.folder
        self.chance = chance
        self.out = self.folder / "out"
        self.out.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={_DISK}", "soak", str(self.out)], check=True)
        self.endpoint = f"tcp/{hosts.address('middle')}:7447"
        self.router = self._router()
        self.agents = {name: self._agent(name) for name in SIDES}
        (self.folder / "soak.yaml").write_text(GRAPH)
        (self.folder / "placement.yaml").write_text(PLACEMENT)
        words = ["run", "soak.yaml", "--placement", "placement.yaml", "--plugin", STAGES, "--out", self.out]
        self.run = hosts.start("desk", *words, "--json", "--quiet", "--insecure", "--router", self.endpoint)

    def end(self) -> None:
        """Ask agents and the router to end."""
        for agent in self.agents.values():
            agent.end()
        self.router.terminate()
        self.router.communicate(timeout=30)

    def close(self) -> None:
        """The disk goes; processes and namespaces are those of the hosts."""
        subprocess.run(["umount", "--lazy", str(self.out)], check=False)

    def heard(self, since: float) -> set[int]:
        """Sides that were heard after a time, s of the monotonic clock."""
        path = self.out / "beats.csv"
        if not path.exists():
            return set()
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - 4000))
            lines = file.read().decode().splitlines()[1:]
        sides: set[int] = set()
        for line in lines:
            when, _, found = line.partition(",")
            if found and float(when) > since:
                sides.update(map(int, found.split()))
        return sides

    def workers(self) -> list[int]:
        """Process ids of all workers."""
        hosts = [self.run.pid, *(agent.process.pid for agent in self.agents.values())]
        return [pid for host in hosts for pid in children(host)]

    def kill_worker(self) -> None:
        """SIGKILL."""
        self._signal_worker(signal.SIGKILL)

    def stop_worker(self) -> None:
        """SIGSTOP: it hangs until its host kills it."""
        self._signal_worker(signal.SIGSTOP)

    def kill_agent(self) -> None:
        """The agent dies and is started again by whoever looks after the host."""
        name = self.chance.choice(SIDES)
        self.agents[name].process.kill()
        self.agents[name].process.communicate()
        self.agents[name] = self._agent(name)

    def stop_agent(self) -> None:
        """The agent hangs for a while; its workers go on."""
        agent = self.agents[self.chance.choice(SIDES)]
        agent.signal(signal.SIGSTOP)
        time.sleep(CUT_S)
        agent.signal(signal.SIGCONT)

    def cut_link(self) -> None:
        """The cable of a host is pulled and plugged in again."""
        name = self.chance.choice(SIDES)
        self.hosts.link(name, "down")
        time.sleep(CUT_S)
        self.hosts.link(name, "up")

    def restart_router(self) -> None:
        """The router dies and is started again."""
        self.router.kill()
        self.router.communicate()
        self.router = self._router()

    def fill_disk(self) -> None:
        """The disk of the sink is full for a second."""
        filler = self.out / "filler"
        try:
            filler.write_bytes(bytes(2 * _DISK))
        except OSError:
            time.sleep(1.0)
        finally:
            filler.unlink(missing_ok=True)

    def step_clock(self) -> None:
        """The clock of a host jumps by 50 ms, forth or back."""
        name = self.chance.choice(SIDES)
        for path in self.folder.glob(f"runs/*-{name}"):
            (path / CLOCK).write_text(self.chance.choice(["50000000", "0", "-50000000"]))

    def _signal_worker(self, number: signal.Signals) -> None:
        pids = self.workers()
        if pids:
            os.kill(self.chance.choice(pids), number)

    def _router(self) -> subprocess.Popen[str]:
        router: subprocess.Popen[str] = self.hosts.start(
            "middle", "router", "--listen", self.endpoint, "--insecure"
        )
        return router

    def _agent(self, name: str) -> Agent:
        return self.hosts.agent(name, "--plugin", STAGES, router=self.endpoint)


FAULTS: dict[str, Callable[[Show], None]] = {
    "worker killed": Show.kill_worker,
    "worker hangs": Show.stop_worker,
    "agent killed": Show.kill_agent,
    "agent hangs": Show.stop_agent,
    "link down": Show.cut_link,
    "router restarted": Show.restart_router,
    "disk full": Show.fill_disk,
    "clock steps": Show.step_clock,
}

"""The show of tools/soak.py: hosts, agents, a router and a live run in network namespaces, and its faults."""

from __future__ import annotations

import os
import random
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from tests.integration.hosts import Agent, Hosts  # noqa: E402
from tests.integration.running import alive, descendants, unused_memory, workers  # noqa: E402
from tests.promises.ledger_check import Journals, disagreements, journals_of  # noqa: E402

from soaking.room import write_files  # noqa: E402
from soaking.watch import Watch  # noqa: E402

__all__ = [
    "FAULTS",
    "SIDES",
    "UNSEEN",
    "Hosts",
    "Journals",
    "Show",
    "descendants",
    "disagreements",
    "journals_of",
    "unused_memory",
]

STAGES = Path(__file__).with_name("journaled.py")
SIDES = ("pc-left", "pc-right")
CLOCKS = Path(__file__).with_name("clock")
STEP = 50_000_000
"""Step of a host's clock, ns."""
CUT_S = 2.5
"""Seconds for which cables are pulled and agents stopped: longer than a peer may be silent."""
LONG_S = 12.0
"""Seconds for which hosts do not hear of each other: after 10 s an agent counts its operator as silent."""
_DISK = 8 << 20
"""Bytes of the disk that the run writes to."""
_LAST = 10_000
"""Bytes read from the end of the judge's file: more than a fault lasts."""


class Show:
    """Everything that runs: a router, two agents, a run; what can be seen of it, and what can befall it."""

    def __init__(self, hosts: Hosts, chance: random.Random, projections: int) -> None:
        self.hosts = hosts
        self.folder = hosts.folder
        self.chance = chance
        self.clocks: dict[str, int] = {}
        self.journals = self.folder / "journals"
        self.journals.mkdir()
        os.environ["JOURNALS"] = str(self.journals)
        self.killed: set[int] = set()
        """Workers that were killed, or stopped until their host killed them."""
        self.out = self.folder / "out"
        self.out.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={_DISK}", "soak", str(self.out)], check=True)
        self.endpoint = f"tcp/{hosts.address('middle')}:7447"
        self.router = self._router()
        for name in SIDES:
            self._set_clock(name, 0)
        self.agents = {name: self._agent(name) for name in SIDES}
        write_files(self.folder, opened=time.monotonic(), projections=projections)
        words: list[str | Path] = [
            "run",
            "soak.yaml",
            "--placement",
            "placement.yaml",
            "--plugin",
            STAGES,
            "--out",
            self.out,
        ]
        self.run = hosts.start("desk", *words, "--json", "--quiet", "--insecure", "--router", self.endpoint)
        self.watch = Watch(self.run.pid, hosts.space("desk"))

    def end(self) -> None:
        """Ask agents and the router to end."""
        for agent in self.agents.values():
            agent.end()
        self.router.terminate()
        self.router.communicate(timeout=30)

    def close(self) -> None:
        """Close the watch and unmount the disk; `Hosts` ends processes and namespaces."""
        self.watch.close()
        subprocess.run(["umount", "--lazy", str(self.out)], check=False)

    def judged(self) -> list[tuple[float, int, float]]:
        """When the last frames were tracked, s of the monotonic clock, their numbers, and the errors, m."""
        path = self.out / "judged.csv"
        if not path.exists():
            return []
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - _LAST))
            lines = [line.split(",") for line in file.read().decode().splitlines()[1:]]
        whole = (line for line in lines if len(line) == 3 and line[2])
        return [(float(when), int(frame), float(error)) for when, frame, error in whole]

    def workers(self) -> list[int]:
        """Process ids of all workers."""
        hosts = [self.run.pid, *(agent.process.pid for agent in self.agents.values())]
        return [pid for host in hosts for pid in workers(host) if alive(pid)]

    def signal_worker(self, number: signal.Signals) -> None:
        """SIGKILL; or SIGSTOP: it hangs until its host kills it."""
        pids = self.workers()
        if pids:
            pid = self.chance.choice(pids)
            self.killed.add(pid)
            os.kill(pid, number)

    def kill_agent(self) -> None:
        """Kill the agent and start it again, as a service manager does."""
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

    def cut_link(self, seconds: float) -> None:
        """The cable of a host is pulled and plugged in again."""
        name = self.chance.choice(SIDES)
        self.hosts.link(name, "down")
        time.sleep(seconds)
        self.hosts.link(name, "up")

    def cut_one_way(self) -> None:
        """Drop what is sent to a host or to the desk; what it sends arrives."""
        name = self.chance.choice(("desk", *SIDES))
        self.hosts.deafen(name, True)
        time.sleep(LONG_S)
        self.hosts.deafen(name, False)

    def stop_operator(self) -> None:
        """The operator's process is suspended; the workers of the desk go on."""
        self.run.send_signal(signal.SIGSTOP)
        time.sleep(LONG_S)
        self.run.send_signal(signal.SIGCONT)

    def restart_router(self, seconds: float) -> None:
        """The router dies and is started again later."""
        self.router.kill()
        self.router.communicate()
        time.sleep(seconds)
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
        """The clock of a host jumps, forth or back."""
        name = self.chance.choice(SIDES)
        self._set_clock(name, 0 if self.clocks[name] else self.chance.choice([STEP, -STEP]))

    def _set_clock(self, name: str, error: int) -> None:
        self.clocks[name] = error
        path = self.folder / f"{name}.clock"
        path.touch()
        with path.open("r+b") as file:  # its size must stay, because processes have it mapped
            file.write(struct.pack("<q", error))

    def _router(self) -> subprocess.Popen[str]:
        router: subprocess.Popen[str] = self.hosts.start(
            "middle", "router", "--listen", self.endpoint, "--insecure"
        )
        assert router.stderr is not None
        while "listens on" not in (line := router.stderr.readline()):
            assert line, "the router ended"
        return router

    def _agent(self, name: str) -> Agent:
        paths = os.pathsep.join([str(CLOCKS), *filter(None, [os.environ.get("PYTHONPATH")])])
        env = {"SOAK_CLOCK": str(self.folder / f"{name}.clock"), "PYTHONPATH": paths}
        return self.hosts.agent(name, "--plugin", STAGES, router=self.endpoint, env=env)


FAULTS: dict[str, Callable[[Show], None]] = {
    "worker killed": partial(Show.signal_worker, number=signal.SIGKILL),
    "worker hangs": partial(Show.signal_worker, number=signal.SIGSTOP),
    "agent killed": Show.kill_agent,
    "agent hangs": Show.stop_agent,
    "link down": partial(Show.cut_link, seconds=CUT_S),
    "link down for long": partial(Show.cut_link, seconds=LONG_S),
    "cut one way": Show.cut_one_way,
    "operator suspended": Show.stop_operator,
    "router restarted": partial(Show.restart_router, seconds=0.0),
    "router away": partial(Show.restart_router, seconds=LONG_S),
    "disk full": Show.fill_disk,
    "clock steps": Show.step_clock,
}
UNSEEN = ("operator suspended", "router restarted", "disk full", "clock steps")
"""Faults too short to be noticed, or without a process that could notice them."""

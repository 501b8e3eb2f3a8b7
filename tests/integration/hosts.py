"""Hosts for tests: network namespaces joined by a bridge in a further namespace, and agents in them."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Self

from tests.commands import COMMAND, Process, launch
from tests.integration.running import STAGES

PORT = 7450


@cache
def namespaces_are_permitted() -> bool:
    """True if this user may make network namespaces."""
    name = f"fs{os.getpid()}-try"
    try:
        made = subprocess.run(["ip", "netns", "add", name], capture_output=True, check=False)
    except FileNotFoundError:
        return False
    subprocess.run(["ip", "netns", "del", name], capture_output=True, check=False)
    return made.returncode == 0


def ip(*words: str, inside: str | None = None) -> None:
    prefix = ["ip", "-n", inside] if inside else ["ip"]
    subprocess.run([*prefix, *words], check=True, capture_output=True)


_HELD: list[socket.socket] = []
"""Sockets that reserve the ports of `free_port` without listening, so that another process can listen."""


def free_port() -> int:
    """A free port of loopback, reserved so that the kernel gives it to no other process."""
    sock = socket.socket()
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    sock.bind(("127.0.0.1", 0))
    _HELD.append(sock)
    return int(sock.getsockname()[1])


class Hosts:
    """Hosts on one network; each name becomes a namespace, the first is the operator's host."""

    def __init__(self, folder: Path, names: Sequence[str]) -> None:
        self.folder = folder
        self.names = list(names)
        self.processes: list[subprocess.Popen[str]] = []
        self.tag = f"fs{os.getpid()}"

    def __enter__(self) -> Self:
        try:
            self._make()
        except BaseException:
            self.close()
            raise
        return self

    def _make(self) -> None:
        hub = self.space("hub")
        ip("netns", "add", hub)
        ip("link", "add", "switch", "type", "bridge", inside=hub)
        ip("link", "set", "switch", "up", inside=hub)
        for number, name in enumerate(self.names):
            space = self.space(name)
            ip("netns", "add", space)
            ip(
                "link",
                "add",
                f"to{number}",
                "type",
                "veth",
                "peer",
                "name",
                "eth0",
                "netns",
                space,
                inside=hub,
            )
            ip("link", "set", f"to{number}", "master", "switch", "up", inside=hub)
            ip("addr", "add", f"{self.address(name)}/24", "dev", "eth0", inside=space)
            ip("link", "set", "eth0", "up", inside=space)
            ip("link", "set", "lo", "up", inside=space)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.communicate()
        for name in ["hub", *self.names]:
            subprocess.run(["ip", "netns", "del", self.space(name)], capture_output=True, check=False)

    def space(self, name: str) -> str:
        return f"{self.tag}-{name}"

    def address(self, name: str) -> str:
        return f"10.83.7.{self.names.index(name) + 1}"

    def endpoint(self, name: str) -> str:
        return f"tcp/{self.address(name)}:{PORT}"

    def link(self, name: str, state: str) -> None:
        """Take the link of a host "down" or "up"."""
        ip("link", "set", f"to{self.names.index(name)}", state, inside=self.space("hub"))

    def deafen(self, name: str, deaf: bool) -> None:
        """Silently drop all packets to a host, but none from it; deaf=False stops that."""
        at = ("dev", f"to{self.names.index(name)}", "root")
        words = ("add", *at, "blackhole") if deaf else ("del", *at)
        inside = ("ip", "netns", "exec", self.space("hub"))
        subprocess.run([*inside, "tc", "qdisc", *words], check=True, capture_output=True)

    def throttle(self, name: str, rate: str) -> None:
        """Let a host send no faster than a rate, such as "2mbit"; packets queue for up to 1 s."""
        words = (
            "tc",
            "qdisc",
            "add",
            "dev",
            "eth0",
            "root",
            "tbf",
            "rate",
            rate,
            "burst",
            "8kb",
            "latency",
            "1s",
        )
        subprocess.run(["ip", "netns", "exec", self.space(name), *words], check=True, capture_output=True)

    def start(
        self, host: str, *words: str | Path, env: Mapping[str, str] | None = None
    ) -> subprocess.Popen[str]:
        """Start a followspot command on a host; env: added to the environment of the test."""
        process = subprocess.Popen(
            ["ip", "netns", "exec", self.space(host), *COMMAND, *map(str, words)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=self.folder,
            env={**os.environ, **(env or {})},
        )
        self.processes.append(process)
        return process

    def agent(
        self, name: str, *options: str | Path, router: str = "", env: Mapping[str, str] | None = None
    ) -> Agent:
        """Start an agent and wait until it is ready. router: the router that it connects to."""
        listen = ("--router", router) if router else ("--listen", self.endpoint(name))
        words = ("agent", "--name", name, *listen, "--insecure", *options)
        return Agent(self.start(name, *words, env=env), self.folder)


class Agent:
    """A ready `followspot agent`, on this host or in a namespace."""

    def __init__(self, process: Process, folder: Path) -> None:
        self.process = process
        assert process.stderr is not None
        self.lines: list[str] = []
        while not self.lines or "listens on" not in self.lines[-1]:
            line = process.stderr.readline()
            assert line, f"the agent ended: {self.lines}"
            self.lines.append(line.strip())
        self.folder = folder

    @property
    def endpoint(self) -> str:
        """The endpoint that it listens on."""
        return self.lines[-1].rpartition(" ")[2]

    def signal(self, number: signal.Signals) -> None:
        self.process.send_signal(number)

    def end(self) -> int:
        self.process.terminate()
        self.process.communicate(timeout=30)
        return self.process.wait()


def near_agent(name: str, folder: Path, *options: str | Path, at: str = "tcp/127.0.0.1:0") -> Agent:
    """An agent on this host, reached through loopback; at: its endpoint, by default at a free port."""
    words = ["agent", "--name", name, "--listen", at, "--plugin", STAGES, *options]
    return Agent(launch(*words, cwd=folder), folder)

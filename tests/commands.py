"""Runs `followspot` commands in processes that are forked from one that has imported what most of them need.

A command that starts anew imports for half a second and more, and the tests start hundreds. Each still has a
process, a folder, an environment and outputs of its own, and signals do what they do to others. Tests that
change what can be imported start a new interpreter instead (`COMMAND`).
"""

from __future__ import annotations

import functools
import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from tests.forking import NUMBER

if TYPE_CHECKING:
    from typing import IO, Self

COMMAND = [sys.executable, "-m", "followspot.cli.main"]


def command(
    *words: object,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
    timeout: float = 600.0,
    check: bool = False,
) -> subprocess.CompletedProcess[str]:
    """What `subprocess.run([*COMMAND, *words], capture_output=True, text=True, ...)` gives.

    check: whether it must work.
    """
    with launch(*words, cwd=cwd, env=env) as started:
        try:
            out, errors = started.communicate(timeout)
        except subprocess.TimeoutExpired:
            started.kill()
            raise
    done = subprocess.CompletedProcess(started.args, started.wait(), out, errors)
    assert not check or not done.returncode, done.stderr + done.stdout
    return done


class Started:
    """A command that goes on, with what tests need of `subprocess.Popen`.

    pid: its process; stdout, stderr: what it says.
    """

    def __init__(self, words: list[str], status: socket.socket, stdout: IO[str], stderr: IO[str]) -> None:
        self.args, self.stdout, self.stderr = words, stdout, stderr
        self.returncode: int | None = None
        self._status = status
        self.pid = _number(status)
        self._said: tuple[Future[str], Future[str]] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *found: object) -> None:
        self.wait()
        if self._said is None:
            self.stdout.close()
            self.stderr.close()

    def poll(self) -> int | None:
        """Its exit code, None while it goes on."""
        if self.returncode is None and select.select([self._status], [], [], 0)[0]:
            self.wait()
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code. Raises subprocess.TimeoutExpired."""
        if self.returncode is None:
            if not select.select([self._status], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
            self.returncode = _number(self._status)
            self._status.close()
        return self.returncode

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """The rest of what it says until its end. Raises subprocess.TimeoutExpired."""
        until = None if timeout is None else time.monotonic() + timeout
        if self._said is None:
            readers = ThreadPoolExecutor(2)
            self._said = readers.submit(_rest, self.stdout), readers.submit(_rest, self.stderr)
            readers.shutdown(wait=False)
        try:
            out, errors = (said.result(until and max(until - time.monotonic(), 0.0)) for said in self._said)
        except TimeoutError:
            raise subprocess.TimeoutExpired(self.args, timeout or 0.0) from None
        self.wait(until and max(until - time.monotonic(), 0.0))
        return out, errors

    def send_signal(self, number: signal.Signals) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)


Process = subprocess.Popen[str] | Started


def launch(*words: object, cwd: Path | None = None, env: Mapping[str, str] | None = None) -> Started:
    """What `subprocess.Popen([*COMMAND, *words], stdout=PIPE, stderr=PIPE, text=True)` starts."""
    said = list(map(str, words))
    order = json.dumps([said, str(cwd or Path.cwd()), dict(os.environ if env is None else env)]).encode()
    status, theirs = socket.socketpair()
    out, out_end = os.pipe()
    errors, errors_end = os.pipe()
    server = _server()
    socket.send_fds(server, [NUMBER.pack(len(order))], [out_end, errors_end, theirs.fileno()])
    server.sendall(order)
    for end in (out_end, errors_end):
        os.close(end)
    theirs.close()
    return Started(said, status, os.fdopen(out), os.fdopen(errors))


@functools.cache
def _server() -> socket.socket:
    """A socket to the process that forks; it ends with this one."""
    here, there = socket.socketpair()
    with there:
        subprocess.Popen(
            [sys.executable, Path(__file__).with_name("forking.py"), str(there.fileno())],
            pass_fds=[there.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},  # as the command sets it
        )
    return here


def _number(status: socket.socket) -> int:
    text = status.recv(NUMBER.size, socket.MSG_WAITALL)
    assert len(text) == NUMBER.size, "the process that starts commands has ended"
    return int(NUMBER.unpack(text)[0])


def _rest(output: IO[str]) -> str:
    with output:
        return output.read()

"""Control socket: the carrier of requests between processes of one user on this machine.

A request and its answer are one line of JSON each. The socket's name is abstract: the kernel removes it when
its process dies. Both sides check the user of the other process, so no other user can ask or answer.
"""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from struct import Struct
from typing import Any

from followspot.control.dispatch import Ask, Dispatcher, NoAnswer, Request, answer_from_wire, to_wire
from followspot.errors import FollowspotError

MAX_REQUEST = 1 << 20
"""Longest request, bytes."""
_MAX_ANSWER = 64 << 20
_TIMEOUT = 5.0
"""Seconds that a request has to arrive after its sender has connected, and a run to describe itself."""
_SOCKETS = Path("/proc/net/unix")
_RUN_NAME_LENGTH = 8
"""Letters that identify a run among others."""
_PEER = Struct("3i")
"""Process, user and group of the peer, as SO_PEERCRED gives them."""

_DESCRIBE = {"verb": "describe"}
"""Asks for the run behind a socket; the carrier answers it itself."""


@contextmanager
def serve_requests(run: str, graph: str, dispatcher: Dispatcher) -> Iterator[None]:
    """Serve requests of other processes while the block runs, each in a thread of its own.

    If the socket cannot be opened, the block runs without it and standard error says why.
    """
    about = {"run": run, "graph": graph, "pid": os.getpid()}
    try:
        server = _Server(f"{_prefix()}{os.getpid()}-{run[:16]}", about, dispatcher)
    except OSError as error:
        sys.stderr.write(f"followspot: this run cannot be watched or changed: {error}\n")
        yield
        return
    try:
        yield
    finally:
        server.close()


@dataclass(frozen=True)
class ServedRun:
    """A run whose process serves requests, here. graph: "" if it does not answer; ask: sends it requests."""

    run: str
    graph: str
    pid: int
    ask: Ask


def served_here(wanted: str | None = None) -> list[ServedRun]:
    """The user's runs on this machine, sorted by name.

    wanted: a process id or the beginning of a run's name; if there is such a run, only it is asked.
    """
    try:
        addresses = {line.rpartition(" ")[2] for line in _SOCKETS.read_text(errors="replace").splitlines()}
    except OSError:
        return []
    found = []
    names = sorted(word[1:] for word in addresses if word.startswith(f"@{_prefix()}"))
    meant = [name for name in names if wanted and _is_meant(wanted, name)]
    for name in meant or names:
        with suppress(OSError, FollowspotError, KeyError, TypeError, ValueError):  # the run has just ended
            found.append(_described(name))
    return found


def _described(name: str) -> ServedRun:
    """The run behind the socket of this name."""
    pid, _, run = name.removeprefix(_prefix()).partition("-")
    try:
        about = _exchange(name, _DESCRIBE, _TIMEOUT)
    except TimeoutError:
        return ServedRun(run, "", int(pid), socket_of(name, run, int(pid)))
    run = str(about["run"])
    return ServedRun(run, str(about["graph"]), int(pid), socket_of(name, run, int(pid)))


def socket_of(name: str, run: str, pid: int) -> Ask:
    """An `Ask` for the run behind the socket of this name. run, pid: its name and process, for errors."""

    def ask(request: Request, timeout: float) -> Any:
        try:
            return answer_from_wire(type(request), _exchange(name, to_wire(request), timeout))
        except TimeoutError:
            raise NoAnswer(f"the run {run[:8]} does not answer: {_why_silent(pid)}") from None
        except OSError as error:
            raise FollowspotError(f"the run {run[:8]} does not answer: {error}") from None
        except ValueError as error:
            raise FollowspotError(f"the run {run[:8]} gave an invalid answer: {error}") from None

    return ask


class _Server:
    """Answers requests on a socket of this name, each in a thread of its own."""

    def __init__(self, name: str, about: dict[str, Any], dispatcher: Dispatcher) -> None:
        """about: the answer to `_DESCRIBE`. Raises OSError."""
        self._about = about
        self._dispatcher = dispatcher
        self._clients: dict[threading.Thread, socket.socket] = {}
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._socket.bind(f"\0{name}")
            self._socket.listen()
        except OSError:
            self._socket.close()
            raise
        self._thread = threading.Thread(target=self._serve, name="control", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Accept no more requests, and finish those that have arrived."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join(_TIMEOUT)
        self._socket.close()
        clients = list(self._clients.items())
        for _, client in clients:  # a client that has not sent its request yet is too late
            with suppress(OSError):
                client.shutdown(socket.SHUT_RD)
        deadline = time.monotonic() + _TIMEOUT
        for thread, _ in clients:
            thread.join(max(0.0, deadline - time.monotonic()))

    def _serve(self) -> None:
        """Accept clients of this user until `close`."""
        while True:
            try:
                client, _ = self._socket.accept()
            except OSError:
                return
            if not _same_user(client):
                client.close()
                continue
            thread = threading.Thread(target=self._answer, args=(client,), daemon=True)
            self._clients[thread] = client
            thread.start()

    def _answer(self, client: socket.socket) -> None:
        """Answer the one request of a client."""
        try:
            with client, suppress(OSError):
                client.settimeout(_TIMEOUT)
                client.sendall(json.dumps(self._reply(_line(client, MAX_REQUEST))).encode() + b"\n")
        finally:
            del self._clients[threading.current_thread()]

    def _reply(self, line: bytes) -> dict[str, Any]:
        """The answer to a request, or why it is refused."""
        try:
            request = json.loads(line)
            return {
                "answer": self._about if request == _DESCRIBE else self._dispatcher.dispatch_wire(request)
            }
        except (FollowspotError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            return {"refused": str(error) or type(error).__name__}


def _exchange(name: str, request: dict[str, Any], timeout: float) -> Any:
    """Send a request and return its answer. Raises FollowspotError if it is refused, OSError."""
    with socket.socket(socket.AF_UNIX) as ours:
        ours.settimeout(timeout)
        ours.connect(f"\0{name}")
        if not _same_user(ours):
            raise PermissionError("it is a process of another user")
        ours.sendall(json.dumps(request).encode() + b"\n")
        try:
            said = json.loads(_line(ours, _MAX_ANSWER))
        except ValueError as error:
            raise ConnectionError(f"it ended without an answer: {error}") from None
    if "refused" in said:
        raise FollowspotError(str(said["refused"]))
    return said["answer"]


def _line(end: socket.socket, most: int) -> bytes:
    """One line, or the bytes before the end of the stream or the limit."""
    data = bytearray()
    while not data.endswith(b"\n") and len(data) <= most:
        more = end.recv(1 << 16)
        if not more:
            break
        data += more
    return bytes(data)


def _same_user(end: socket.socket) -> bool:
    _, user, _ = _PEER.unpack(end.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size))
    return bool(user == os.getuid())


def _why_silent(pid: int) -> str:
    """Why a process does not answer."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return f"its process {pid} is gone"
    stopped = f"is suspended; kill -CONT {pid} lets it go on"
    return f"its process {pid} {stopped if state in 'Tt' else 'is too busy'}"


def _is_meant(wanted: str, name: str) -> bool:
    pid, _, run = name.removeprefix(_prefix()).partition("-")
    return wanted == pid or (len(wanted) >= _RUN_NAME_LENGTH and run.startswith(wanted[:16]))


def _prefix() -> str:
    """The prefix of the names of this user's sockets."""
    return f"followspot-{os.getuid()}-"

"""Carrier between processes of one user on this machine: how others find a run here and ask it.

One line of JSON there, one back. The socket has an abstract name: no file, so a kill leaves nothing behind.
Both sides look whose process the other one is, so nobody else gets in or answers in a run's place.
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
from pathlib import Path
from struct import Struct
from typing import Any

from followspot.control.dispatch import Dispatcher, Request, answer_from_wire, to_wire
from followspot.errors import FollowspotError
from followspot.operator.run_handle import Ask, NoAnswer, RunHandle

MAX_REQUEST = 1 << 20
"""Longest request, bytes."""
_MAX_ANSWER = 64 << 20
_TIMEOUT = 5.0
"""Seconds for a request to arrive once its sender is there, and for a run to say who it is."""
_SOCKETS = Path("/proc/net/unix")
_TELLING = 8
"""Letters of a run's name that tell it from others."""
_PEER = Struct("3i")
"""Process, user and group at the other end."""

_DESCRIBE = {"verb": "describe"}
"""Asks whose socket it is; answered by the carrier itself."""


@contextmanager
def reachable(run: str, graph: str, dispatcher: Dispatcher) -> Iterator[None]:
    """While the block runs, other processes can ask this one; each request has a thread of its own.

    If they cannot, standard error says why.
    """
    about = {"run": run, "graph": graph, "pid": os.getpid()}
    try:
        server = _Server(f"{_own()}{os.getpid()}-{run[:16]}", about, dispatcher)
    except OSError as error:
        sys.stderr.write(f"followspot: nobody can change this run: {error}\n")
        yield
        return
    try:
        yield
    finally:
        server.close()


def runs_here(wanted: str | None = None) -> list[RunHandle]:
    """The user's runs on this machine, in the order of their names.

    wanted: a process id or the beginning of a run's name: where there is such a run, no other is asked.
    """
    try:
        words = {line.rpartition(" ")[2] for line in _SOCKETS.read_text(errors="replace").splitlines()}
    except OSError:
        return []
    found = []
    names = sorted(word[1:] for word in words if word.startswith(f"@{_own()}"))
    meant = [name for name in names if wanted and _is(wanted, name)]
    for name in meant or names:
        with suppress(OSError, FollowspotError, KeyError, TypeError, ValueError):  # it has just ended
            found.append(_found(name))
    return found


def _found(name: str) -> RunHandle:
    """The run with a socket of this name."""
    pid, _, run = name.removeprefix(_own()).partition("-")
    try:
        about = _asked(name, _DESCRIBE, _TIMEOUT)
    except TimeoutError:
        return RunHandle(run, "", socket_of(name, run, int(pid)), int(pid))
    run = str(about["run"])
    return RunHandle(run, str(about["graph"]), socket_of(name, run, int(pid)), int(pid))


def socket_of(name: str, run: str, pid: int) -> Ask:
    """Asks the run behind a socket of this name. run, pid: its own name and process, for errors."""

    def ask(request: Request, timeout: float) -> Any:
        try:
            return answer_from_wire(type(request), _asked(name, to_wire(request), timeout))
        except TimeoutError:
            raise NoAnswer(f"the run {run[:8]} does not answer: {_why_silent(pid)}") from None
        except OSError as error:
            raise FollowspotError(f"the run {run[:8]} does not answer: {error}") from None
        except ValueError as error:
            raise FollowspotError(f"the run {run[:8]} answers what is not understood: {error}") from None

    return ask


class _Server:
    """Answers on a socket of this name, one thread a question."""

    def __init__(self, name: str, about: dict[str, Any], dispatcher: Dispatcher) -> None:
        """about: answers who this is. Raises OSError."""
        self._about = about
        self._dispatcher = dispatcher
        self._asking: dict[threading.Thread, socket.socket] = {}
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
        """Answer no more, but to the end what has been asked."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join(_TIMEOUT)
        self._socket.close()
        asking = list(self._asking.items())
        for _, client in asking:  # whoever has not asked yet comes too late
            with suppress(OSError):
                client.shutdown(socket.SHUT_RD)
        patient = time.monotonic() + _TIMEOUT
        for thread, _ in asking:
            thread.join(max(0.0, patient - time.monotonic()))

    def _serve(self) -> None:
        while True:
            try:
                client, _ = self._socket.accept()
            except OSError:
                return
            if not _same_user(client):
                client.close()
                continue
            thread = threading.Thread(target=self._answer, args=(client,), daemon=True)
            self._asking[thread] = client
            thread.start()

    def _answer(self, client: socket.socket) -> None:
        try:
            with client, suppress(OSError):
                client.settimeout(_TIMEOUT)
                client.sendall(json.dumps(self._said(_line(client, MAX_REQUEST))).encode() + b"\n")
        finally:
            del self._asking[threading.current_thread()]

    def _said(self, line: bytes) -> dict[str, Any]:
        try:
            request = json.loads(line)
            return {
                "answer": self._about if request == _DESCRIBE else self._dispatcher.dispatch_wire(request)
            }
        except (FollowspotError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            return {"refused": str(error) or type(error).__name__}


def _asked(name: str, request: dict[str, Any], timeout: float) -> Any:
    with socket.socket(socket.AF_UNIX) as ours:
        ours.settimeout(timeout)
        ours.connect(f"\0{name}")
        if not _same_user(ours):
            raise PermissionError("it is a process of somebody else")
        ours.sendall(json.dumps(request).encode() + b"\n")
        try:
            said = json.loads(_line(ours, _MAX_ANSWER))
        except ValueError as error:
            raise ConnectionError(f"it ended without an answer: {error}") from None
    if "refused" in said:
        raise FollowspotError(str(said["refused"]))
    return said["answer"]


def _line(end: socket.socket, most: int) -> bytes:
    """One line, or what came before the end or the limit."""
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
    """What is the matter with a process that does not answer."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return f"its process {pid} is gone"
    stopped = f"is suspended; kill -CONT {pid} lets it go on"
    return f"its process {pid} {stopped if state in 'Tt' else 'is too busy'}"


def _is(wanted: str, name: str) -> bool:
    pid, _, run = name.removeprefix(_own()).partition("-")
    return wanted == pid or (len(wanted) >= _TELLING and run.startswith(wanted[:16]))


def _own() -> str:
    """What the names of this user's sockets begin with."""
    return f"followspot-{os.getuid()}-"

"""How other processes of the same user find a run on this machine: a socket that knows a few verbs.

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
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from struct import Struct
from typing import Any

from followspot.errors import FollowspotError

MAX_REQUEST = 1 << 20
"""Longest request, bytes."""
_MAX_ANSWER = 64 << 20
_PATIENCE = 5.0
"""Seconds for a request to arrive once its sender is there, and for a run to say who it is."""
_SOCKETS = Path("/proc/net/unix")
_TELLING = 8
"""Letters of a run's name that tell it from others."""
_PEER = Struct("3i")
"""Process, user and group at the other end."""


class NoAnswer(FollowspotError):
    """The run's process is there, but does not answer in time: it is suspended, or very busy."""


Verbs = Mapping[str, Callable[..., Any]]
"""What can be asked: functions of JSON types that return JSON types; each call has a thread of its own."""


@dataclass(frozen=True)
class RunHere:
    """A run on this machine, its process, and the name of its socket; graph: "" where it does not answer."""

    run: str
    graph: str
    pid: int
    socket: str

    @property
    def label(self) -> str:
        """For lists of runs."""
        silent = f" of process {self.pid}, which does not answer"
        return f"{self.graph} ({self.run[:8]})" if self.graph else self.run[:8] + silent

    def silent(self) -> NoAnswer:
        """The error of one that does not answer."""
        return NoAnswer(f"the run {self.run[:8]} does not answer: {_why_silent(self.pid)}")

    def ask(self, verb: str, timeout: float | None = None, **data: Any) -> Any:
        """Its answer. Raises FollowspotError where it refuses, or ends meanwhile.

        timeout: time to answer, s, None for as long as it takes; NoAnswer is raised after it.
        """
        try:
            return _asked(self.socket, verb, timeout, **data)
        except TimeoutError:
            raise self.silent() from None
        except OSError as error:
            raise FollowspotError(f"the run {self.run[:8]} does not answer: {error}") from None


@contextmanager
def reachable(run: str, graph: str, verbs: Verbs) -> Iterator[None]:
    """While the block runs, other processes can ask this one. Where they cannot, standard error says why."""
    about = {"describe": lambda: {"run": run, "graph": graph, "pid": os.getpid()}}
    try:
        server = _Server(f"{_own()}{os.getpid()}-{run[:16]}", {**about, **verbs})
    except OSError as error:
        sys.stderr.write(f"followspot: nobody can change this run: {error}\n")
        yield
        return
    try:
        yield
    finally:
        server.close()


def runs_here(wanted: str | None = None) -> list[RunHere]:
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


def _found(name: str) -> RunHere:
    """The run with a socket of this name."""
    try:
        about = _asked(name, "describe", _PATIENCE)
    except TimeoutError:
        pid, _, run = name.removeprefix(_own()).partition("-")
        return RunHere(run, "", int(pid), name)
    return RunHere(str(about["run"]), str(about["graph"]), int(about["pid"]), name)


class _Server:
    """Answers on a socket of this name, one thread a question."""

    def __init__(self, name: str, verbs: Verbs) -> None:
        """Raises OSError."""
        self._verbs = verbs
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
        self._thread.join(_PATIENCE)
        self._socket.close()
        asking = list(self._asking.items())
        for _, asker in asking:  # whoever has not asked yet comes too late
            with suppress(OSError):
                asker.shutdown(socket.SHUT_RD)
        patient = time.monotonic() + _PATIENCE
        for thread, _ in asking:
            thread.join(max(0.0, patient - time.monotonic()))

    def _serve(self) -> None:
        while True:
            try:
                asker, _ = self._socket.accept()
            except OSError:
                return
            if not _same_user(asker):
                asker.close()
                continue
            thread = threading.Thread(target=self._answer, args=(asker,), daemon=True)
            self._asking[thread] = asker
            thread.start()

    def _answer(self, asker: socket.socket) -> None:
        try:
            with asker, suppress(OSError):
                asker.settimeout(_PATIENCE)
                asker.sendall(json.dumps(self._said(_line(asker, MAX_REQUEST))).encode() + b"\n")
        finally:
            del self._asking[threading.current_thread()]

    def _said(self, line: bytes) -> dict[str, Any]:
        try:
            request = json.loads(line)
            return {"answer": self._verbs[request.pop("verb")](**request)}
        except (FollowspotError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            return {"refused": str(error) or type(error).__name__}


def _asked(name: str, verb: str, timeout: float | None, **data: Any) -> Any:
    with socket.socket(socket.AF_UNIX) as ours:
        ours.settimeout(timeout)
        ours.connect(f"\0{name}")
        if not _same_user(ours):
            raise PermissionError("it is a process of somebody else")
        ours.sendall(json.dumps({"verb": verb, **data}).encode() + b"\n")
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

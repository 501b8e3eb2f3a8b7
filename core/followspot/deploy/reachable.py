"""How other processes of the same user find a run on this machine: a private socket that knows a few verbs.

One line of JSON there, one back. The folder is the user's own, so nobody else gets in.
"""

from __future__ import annotations

import json
import os
import socket
import stat
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError

MAX_LINE = 1 << 20
"""Longest request or answer, bytes."""
_PATIENCE = 5.0
"""Seconds for a request to arrive once its sender is there, and for a run to say who it is."""
_SUFFIX = ".sock"

Verbs = Mapping[str, Callable[..., Any]]
"""What can be asked: functions of JSON types that return JSON types; each call has a thread of its own."""


@dataclass(frozen=True)
class RunHere:
    """A run on this machine, its process, and the name of its socket."""

    run: str
    graph: str
    pid: int
    socket: str

    def ask(self, verb: str, timeout: float | None = None, **data: Any) -> Any:
        """Its answer. Raises FollowspotError where it refuses, or ends meanwhile."""
        try:
            return _asked(self.socket, verb, timeout, **data)
        except OSError as error:
            raise FollowspotError(f"the run {self.run[:8]} does not answer: {error}") from None


@contextmanager
def reachable(run: str, graph: str, verbs: Verbs) -> Iterator[None]:
    """While the block runs, other processes can ask this one. Where they cannot, standard error says why."""
    about = {"describe": lambda: {"run": run, "graph": graph, "pid": os.getpid()}}
    try:
        server = _Server(f"{run[:16]}{_SUFFIX}", {**about, **verbs})
    except OSError as error:
        sys.stderr.write(f"followspot: nobody can change this run: {error}\n")
        yield
        return
    try:
        yield
    finally:
        server.close()


def runs_here() -> list[RunHere]:
    """The user's runs on this machine, in the order of their names; what dead ones left is removed."""
    try:
        names = sorted(name for name in os.listdir(_folder()) if name.endswith(_SUFFIX))  # noqa: PTH208
    except OSError:
        return []
    found = []
    for name in names:
        try:
            about = _asked(name, "describe", _PATIENCE)
            found.append(RunHere(str(about["run"]), str(about["graph"]), int(about["pid"]), name))
        except ConnectionRefusedError:
            with suppress(OSError):
                (_folder() / name).unlink()
        except (OSError, FollowspotError, KeyError):
            continue  # it has just ended
    return found


class _Server:
    """Answers on a socket of this name, one thread a question."""

    def __init__(self, name: str, verbs: Verbs) -> None:
        """Raises OSError."""
        self._verbs = verbs
        self._name = name
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            with _within(name) as path:
                self._socket.bind(path)
                os.chmod(path, 0o600)  # noqa: PTH101
            self._socket.listen()
        except OSError:
            self._socket.close()
            raise
        threading.Thread(target=self._serve, name="control", daemon=True).start()

    def close(self) -> None:
        """Answer no more, and leave nothing behind."""
        with suppress(OSError):
            (_folder() / self._name).unlink()
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _serve(self) -> None:
        while True:
            try:
                asker, _ = self._socket.accept()
            except OSError:
                return
            threading.Thread(target=self._answer, args=(asker,), daemon=True).start()

    def _answer(self, asker: socket.socket) -> None:
        with asker, suppress(OSError):
            asker.settimeout(_PATIENCE)
            asker.sendall(json.dumps(self._said(_line(asker))).encode() + b"\n")

    def _said(self, line: bytes) -> dict[str, Any]:
        try:
            request = json.loads(line)
            return {"answer": self._verbs[request.pop("verb")](**request)}
        except (FollowspotError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            return {"refused": str(error) or type(error).__name__}


def _asked(name: str, verb: str, timeout: float | None, **data: Any) -> Any:
    with socket.socket(socket.AF_UNIX) as ours:
        ours.settimeout(timeout)
        with _within(name) as path:
            ours.connect(path)
        ours.sendall(json.dumps({"verb": verb, **data}).encode() + b"\n")
        try:
            said = json.loads(_line(ours))
        except ValueError as error:
            raise ConnectionError(f"it ended without an answer: {error}") from None
    if "refused" in said:
        raise FollowspotError(str(said["refused"]))
    return said["answer"]


def _line(end: socket.socket) -> bytes:
    """One line, or what came before the end or the limit."""
    data = bytearray()
    while not data.endswith(b"\n") and len(data) <= MAX_LINE:
        more = end.recv(1 << 16)
        if not more:
            break
        data += more
    return bytes(data)


def _folder() -> Path:
    """The user's own folder for sockets. Raises OSError where it is somebody else's."""
    own = f"followspot-{os.getuid()}"
    given = os.environ.get("XDG_RUNTIME_DIR", "")
    folder = Path(given if given and Path(given).is_dir() else tempfile.gettempdir()) / own
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise PermissionError(f"{folder} is not a private folder of this user")
    return folder


@contextmanager
def _within(name: str) -> Iterator[str]:
    """A short path to a file of the folder: paths of sockets have at most 107 bytes."""
    fd = os.open(_folder(), os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{fd}/{name}"
    finally:
        os.close(fd)

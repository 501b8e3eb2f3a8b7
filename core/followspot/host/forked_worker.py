"""The host's side of a fork server: starts the server, orders workers, and waits for them."""

from __future__ import annotations

import math
import os
import select
import signal
import socket
import struct
import subprocess
from collections.abc import Iterable
from contextlib import suppress

from followspot.operating_system.child_processes import module_command, start_apart
from followspot.operating_system.descriptors import send_descriptors

PID = struct.Struct("=q")
"""The server's answer to an order."""
EXIT_CODE = struct.Struct("=i")
"""As in `subprocess`: negative if a signal ended the worker."""
EXIT_CODE_UNKNOWN = 255
"""Of a worker whose fork server ended before it."""
_LOOK = 0.5
"""Seconds between two looks whether a server that owes an answer is suspended."""


class ForkedWorker:
    """`Process` of a worker that a fork server forks as soon as its imports are done."""

    def __init__(self, status: socket.socket, server: subprocess.Popen[bytes]) -> None:
        """status: gets the answer of the server, and the exit code."""
        self._status = status
        self._server = server
        self._pid = 0
        self._process: int | None = None
        """Descriptor of the process, which stays that of this process when another gets its number."""
        self._code: int | None = None

    @property
    def pid(self) -> int:
        """Process id; 0 if the server died before it had forked this worker."""
        self._await_fork(None)
        return self._pid

    def poll(self) -> int | None:
        """The exit code; None while the worker is alive."""
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the exit and return its code. Raises subprocess.TimeoutExpired."""
        self._await_fork(timeout)
        if self._code is None:
            assert self._process is not None
            self._await_server(timeout)
            code = self._status.recv(EXIT_CODE.size)
            if not code:  # the server has died, and this worker lives on
                _await(self._process, timeout)
            self._code = EXIT_CODE.unpack(code)[0] if code else EXIT_CODE_UNKNOWN
            os.close(self._process)
            self._status.close()
        return self._code

    def kill(self) -> None:
        """End the worker at once."""
        self._await_fork(None)
        if self._code is None:
            assert self._process is not None
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._process, signal.SIGKILL)

    def _await_server(self, timeout: float | None) -> None:
        """Wait for an answer of the server, or its end. Raises subprocess.TimeoutExpired.

        A suspended server would hide the exit of its workers: it is killed.
        """
        left = math.inf if timeout is None else timeout
        while True:
            if _suspended(self._server):
                self._server.kill()
            try:
                return _await(self._status.fileno(), min(left, _LOOK))
            except subprocess.TimeoutExpired:
                left -= _LOOK
                if left <= 0:
                    raise

    def _await_fork(self, timeout: float | None) -> None:
        """Wait for the server's answer. Raises subprocess.TimeoutExpired."""
        if self._process is not None or self._code is not None:
            return
        self._await_server(timeout)
        pid, descriptors, _, _ = socket.recv_fds(self._status, PID.size, 1, socket.MSG_CMSG_CLOEXEC)
        if descriptors:
            (self._pid,), self._process = PID.unpack(pid), descriptors[0]
        else:
            self._code = EXIT_CODE_UNKNOWN
            self._status.close()


class ForkServerProcess:
    """A fork server, started with its first worker; a new one is started if it has died or is suspended."""

    def __init__(self, stages: Iterable[str]) -> None:
        """stages: names of the stages that the server imports."""
        self._stages = tuple(dict.fromkeys(stages))
        self._server: subprocess.Popen[bytes] | None = None
        self._orders: socket.socket | None = None

    def start(self, end: socket.socket) -> ForkedWorker:
        """Order a worker. end: of its control channel. Raises OSError."""
        if self._server is None or _suspended(self._server) or self._server.poll() is not None:
            self._renew()
        try:
            return self._ordered(end)
        except BrokenPipeError:  # the server was killed a moment ago
            self._renew()
            return self._ordered(end)

    def _renew(self) -> None:
        """End the server, if there is one, and start another."""
        self.close()
        self._server, self._orders = self._start_server()

    def _ordered(self, end: socket.socket) -> ForkedWorker:
        """Order a worker from the server that is there. Raises OSError."""
        assert self._server is not None
        assert self._orders is not None
        status, theirs = socket.socketpair()
        try:
            with theirs:
                send_descriptors(self._orders, b"w", [end.fileno(), theirs.fileno()])
        except BaseException:
            status.close()
            raise
        return ForkedWorker(status, self._server)

    def close(self) -> None:
        """End the server; its workers go on."""
        if self._orders is not None:
            self._orders.close()
        if self._server is not None:
            self._server.kill()  # a suspended one would not see that its orders have ended
            self._server.wait()

    def _start_server(self) -> tuple[subprocess.Popen[bytes], socket.socket]:
        """Start a server; return it with the socket that sends it orders."""
        ours, theirs = socket.socketpair(type=socket.SOCK_SEQPACKET)
        with theirs:
            number = theirs.fileno()
            command = module_command("followspot.host.fork_server", str(number), *self._stages)
            server = start_apart(command, number)
        return server, ours


def _suspended(server: subprocess.Popen[bytes]) -> bool:
    """True if a signal has stopped the process, and none has continued it since."""
    with suppress(ChildProcessError):  # it has ended
        return os.waitid(os.P_PID, server.pid, os.WSTOPPED | os.WNOHANG | os.WNOWAIT) is not None
    return False


def _await(descriptor: int, timeout: float | None) -> None:
    """Wait until the descriptor is readable. Raises subprocess.TimeoutExpired."""
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    if not poll.poll(None if timeout is None else timeout * 1e3):
        raise subprocess.TimeoutExpired("worker", timeout or 0.0)

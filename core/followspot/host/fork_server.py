"""A process that forks the workers of a run, so that what all of them import is imported once.

`python -m followspot.host.fork_server FD STAGE...`: FD is a socket of packets to the host; the stages are
imported first. Each packet orders a worker and brings two sockets: the worker's end of its control channel,
and one that gets an answer, the process id with a descriptor of the process, and at last the exit code.
If imports have started threads, which a fork would lose, each worker imports for itself.
The server ends with its host.
"""

from __future__ import annotations

import gc
import os
import select
import signal
import socket
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import cv2  # noqa: F401 - its threads are not those of stages
import numpy as np

from followspot.host.forked_worker import EXIT_CODE, PID
from followspot.operating_system.child_processes import ignore_terminal, module_command
from followspot.operating_system.descriptors import send_descriptors
from followspot.plugins.registry import PluginError, load_stage
from followspot.worker.main import run_worker


@dataclass
class ForkServer:
    """The server's side. orders: packets of the host."""

    orders: socket.socket
    _workers: dict[int, tuple[int, socket.socket]] = field(default_factory=dict)
    """Process id and socket of the answer, by the descriptor of the process."""

    def forked_worker(self) -> int | None:
        """Serve the host. Returns None when it ends, and in a new worker the descriptor of its channel."""
        poll = select.poll()
        poll.register(self.orders, select.POLLIN)
        while True:
            for descriptor, _ in poll.poll():
                if descriptor in self._workers:
                    poll.unregister(descriptor)
                    self._tell_exit(descriptor)
                    continue
                order, sockets, _, _ = socket.recv_fds(self.orders, 1, 2, socket.MSG_CMSG_CLOEXEC)
                if not order:
                    return None
                end, status = sockets
                if (pid := os.fork()) == 0:
                    os.close(status)
                    self._forget()
                    return end
                os.close(end)
                poll.register(self._answer(pid, socket.socket(fileno=status)), select.POLLIN)

    def _answer(self, pid: int, status: socket.socket) -> int:
        """Tell the host which process the new worker is; return the descriptor of that process."""
        process = os.pidfd_open(pid)
        self._workers[process] = pid, status
        with suppress(OSError):  # the host may have ended
            send_descriptors(status, PID.pack(pid), [process])
        return process

    def _tell_exit(self, process: int) -> None:
        pid, status = self._workers.pop(process)
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        os.close(process)
        with status, suppress(OSError):
            status.sendall(EXIT_CODE.pack(code))

    def _forget(self) -> None:
        """Close the descriptors of the server, in a worker."""
        self.orders.close()
        for process, (_, status) in self._workers.items():
            os.close(process)
            status.close()


def _threads() -> int:
    """Threads of this process, those of libraries included."""
    return sum(1 for _ in Path("/proc/self/task").iterdir())


def _import(stages: Sequence[str]) -> bool:
    """Import the stages; True if this has started threads.

    numpy and OpenCV have started those of their BLAS, which stops and starts them at a fork.
    """
    before = _threads()
    for name in stages:
        with suppress(PluginError):  # the worker that needs it reports this
            load_stage(name)
    return _threads() > before


def main() -> int:
    """Entry of the process."""
    ignore_terminal()
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # the host decides when the server ends
    server = ForkServer(socket.socket(fileno=int(sys.argv[1])))
    threaded = _import(sys.argv[2:])
    warnings.filterwarnings("ignore", "This process .* is multi-threaded", DeprecationWarning)
    gc.freeze()  # so that the pages of what was imported stay shared
    end = server.forked_worker()
    if end is None:
        os._exit(0)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if threaded:
        os.set_inheritable(end, True)
        os.execv(sys.executable, module_command("followspot.worker.main", str(end)))  # noqa: S606
    np.random.seed()  # noqa: NPY002 - else all workers would draw the same numbers
    return run_worker(end)


if __name__ == "__main__":
    sys.exit(main())

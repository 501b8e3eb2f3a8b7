"""How a worker starts: as a thread, or as a process, forked if the host starts several."""

from __future__ import annotations

import socket
from collections.abc import Collection, Iterable

from followspot.host.forked_worker import ForkServerProcess
from followspot.host.worker_process import Process
from followspot.operating_system.child_processes import module_command, start_apart
from followspot.plugins.catalogue import is_builtin


class WorkerStarts:
    """Starts the workers of one run on one host."""

    def __init__(self, workers: Collection[str], threads: Collection[str], stages: Iterable[str]) -> None:
        """workers: all workers of the host; threads: those that are threads; stages: the plugins in use.

        The fork server imports only stages of this distribution: the import of another may open a device.
        """
        self._threads = frozenset(threads)
        several = len(set(workers) - self._threads) > 1
        self._fork_server = (
            ForkServerProcess(name for name in stages if is_builtin(name)) if several else None
        )

    def start(self, name: str, end: socket.socket) -> Process:
        """Start a worker; the socket is its end of the control channel. Raises OSError."""
        if name in self._threads:
            from followspot.host.worker_thread import WorkerThread

            return WorkerThread(name, end)
        if self._fork_server is not None:
            return self._fork_server.start(end)
        return start_apart(module_command("followspot.worker.main", str(end.fileno())), end.fileno())

    def close(self) -> None:
        """End the fork server, if there is one; its workers go on."""
        if self._fork_server is not None:
            self._fork_server.close()

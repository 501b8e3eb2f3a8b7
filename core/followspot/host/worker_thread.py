"""A worker in a thread of this process: no start-up cost, and a debugger sees every stage."""

from __future__ import annotations

import os
import socket
import subprocess
import threading

from followspot.control.pipe import Channel, ChannelClosed
from followspot.control.worker_orders import ORDERS
from followspot.log.collector import collecting
from followspot.worker.blas_limit import ONE_BLAS_THREAD
from followspot.worker.main import WorkerMain
from followspot.worker.process_end import STAGES_CANNOT_EXIT


class WorkerThread:
    """`Process` that is a thread. It cannot be killed: it ends after its control channel is closed."""

    def __init__(self, name: str, end: socket.socket) -> None:
        self.main = WorkerMain(Channel(end.dup(), ORDERS), in_process=True)
        self.pid = os.getpid()
        self._exit_code: int | None = None
        self._thread = threading.Thread(target=self._run, name=f"worker {name}", daemon=True)
        self._thread.start()

    def poll(self) -> int | None:
        """0 if the worker has ended without an error, 1 if with one; None while it is alive."""
        return self._exit_code

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the end and return its code. Raises subprocess.TimeoutExpired."""
        self._thread.join(timeout)
        if self._exit_code is None:
            raise subprocess.TimeoutExpired("worker", timeout or 0.0)
        return self._exit_code

    def kill(self) -> None:
        """Close the control channel: the worker notices that between two firings and ends."""
        self.main.channel.shut()

    def _run(self) -> None:
        """The life of the worker, in its thread."""
        code = 1
        try:
            with ONE_BLAS_THREAD, STAGES_CANNOT_EXIT, collecting(self.main.log):
                self.main.live()
            code = 0
        except ChannelClosed:
            pass
        except Exception:
            self.main.reporter.send_crash()
        finally:
            self.main.channel.close()
            self._exit_code = code

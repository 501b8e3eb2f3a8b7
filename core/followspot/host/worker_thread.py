"""A worker in a thread of this process: no start-up cost, and a debugger sees every stage."""

from __future__ import annotations

import os
import socket
import subprocess
import threading

from followspot.control.pipe import Channel, ChannelClosed
from followspot.control.worker_orders import ORDERS
from followspot.log.collector import collecting
from followspot.worker.main import WorkerMain


class WorkerThread:
    """`Process` that is a thread. It cannot be killed: it ends when its control channel is closed."""

    def __init__(self, name: str, end: socket.socket) -> None:
        self.main = WorkerMain(Channel(end.dup(), ORDERS), in_process=True)
        self.pid = os.getpid()
        self._exit_code: int | None = None
        self._thread = threading.Thread(target=self._live, name=f"worker {name}", daemon=True)
        self._thread.start()

    def poll(self) -> int | None:
        """0 once the worker has ended well, 1 once it has ended otherwise; None while it lives."""
        return self._exit_code

    def wait(self, timeout: float | None = None) -> int:
        """The exit code. Raises subprocess.TimeoutExpired."""
        self._thread.join(timeout)
        if self._exit_code is None:
            raise subprocess.TimeoutExpired("worker", timeout or 0.0)
        return self._exit_code

    def kill(self) -> None:
        """Close the control channel: the worker finds it closed between two firings, and ends."""
        self.main.channel.shut()

    def _live(self) -> None:
        code = 1
        try:
            with collecting(self.main.log):
                self.main.live()
            code = 0
        except ChannelClosed:
            pass
        except Exception:
            self.main.tell_crash()
        finally:
            self.main.channel.close()
            self._exit_code = code

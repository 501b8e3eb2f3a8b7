"""`python tests/forking.py FD` forks a process for each command of a test; FD is a socket to the test.

Each order brings the words, folder and environment of a command, and three descriptors: its two outputs, and
a socket that gets the process id and at last the exit code.
"""

from __future__ import annotations

import gc
import json
import os
import pkgutil
import signal
import socket
import struct
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

WARM = (
    "followspot_accuracy.scorings",
    "followspot_balls.color_blobs",
    "followspot_balls.mean_shift",
    "followspot_sim.rendering.picture",
    "followspot_sinks.csv_file",
    "followspot_target_filter.stage",
    "rich.table",
)
"""What the demo imports beside the core."""
NUMBER = struct.Struct("=q")


def forked(orders: socket.socket) -> bool:
    """Fork a process for each order.

    Returns True in such a process, and False in this one when the test has ended.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the test decides
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for those that wait for commands
    package = import_module("followspot")
    for name in (*(m.name for m in pkgutil.walk_packages(package.__path__, "followspot.")), *WARM):
        import_module(name)
    assert len(list(Path("/proc/self/task").iterdir())) == 1, "a fork would lose threads"
    gc.freeze()
    while True:
        size, descriptors, _, _ = socket.recv_fds(orders, NUMBER.size, 3)
        if not size:
            return False
        order = orders.recv(NUMBER.unpack(size)[0], socket.MSG_WAITALL)
        if os.fork() == 0:
            orders.close()
            return _as_ordered(descriptors, *json.loads(order))
        for descriptor in descriptors:
            os.close(descriptor)


def _as_ordered(descriptors: list[int], words: list[str], folder: str, environment: dict[str, str]) -> bool:
    """Fork the command, and tell what becomes of it; return in the command only."""
    *outputs, status = descriptors
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    if pid := os.fork():
        for output in outputs:
            os.close(output)
        with socket.socket(fileno=status) as told:
            told.sendall(NUMBER.pack(pid))
            code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
            with suppress(BrokenPipeError):  # the test does not want to know
                told.sendall(NUMBER.pack(code))
        os._exit(0)
    os.close(status)
    _prepare(outputs, words, folder, environment)
    return True


def _prepare(outputs: list[int], words: list[str], folder: str, environment: dict[str, str]) -> None:
    """Give this process what a new interpreter would have: outputs, folder, environment, words."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # which `nohup` before the tests would have it ignore
    for number, descriptor in enumerate(outputs, 1):
        os.dup2(descriptor, number)
        os.close(descriptor)
    # The old ones take these for the files that they were.
    sys.stdout = os.fdopen(1, "w", closefd=False)
    sys.stderr = os.fdopen(2, "w", closefd=False, buffering=1, errors="backslashreplace")
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[1:] = words


if __name__ == "__main__":
    sys.path.pop(0)  # a command does not find what stands beside the tests
    sys.exit(
        import_module("followspot.cli.main").main() if forked(socket.socket(fileno=int(sys.argv[1]))) else 0
    )

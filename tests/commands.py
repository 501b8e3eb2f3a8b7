"""Runs `followspot` commands in processes that are forked from one that has imported what most of them need.

A command that starts anew imports for half a second and more, and the tests start hundreds. Each still has a
process, a folder, an environment and outputs of its own. Tests that change what can be imported, or that send
signals, start a new interpreter instead (`COMMAND`).

`python tests/commands.py FD` is the process that forks; FD is a socket to the test.
"""

from __future__ import annotations

import atexit
import functools
import gc
import json
import os
import pkgutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import NoReturn

COMMAND = [sys.executable, "-m", "followspot.cli.main"]
WARM = (
    "followspot_accuracy.scorings",
    "followspot_balls.color_blobs",
    "followspot_balls.mean_shift",
    "followspot_sim.picture",
    "followspot_sinks.csv_file",
    "followspot_target_filter.stage",
    "rich.table",
)
"""What the demo imports beside the core."""
NUMBER = struct.Struct("=q")


def command(
    *words: object,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
    timeout: float = 600.0,
    check: bool = False,
) -> subprocess.CompletedProcess[str]:
    """What `subprocess.run([*COMMAND, *words], capture_output=True, text=True, ...)` gives.

    check: whether it must work.
    """
    said = list(map(str, words))
    order = json.dumps([said, str(cwd or Path.cwd()), dict(os.environ if env is None else env)]).encode()
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
        server = _server()
        socket.send_fds(server, [NUMBER.pack(len(order))], [out.fileno(), errors.fileno()])
        server.sendall(order)
        pid = _number(server)
        server.settimeout(timeout)
        try:
            code = _number(server)
        except TimeoutError:
            os.kill(pid, signal.SIGKILL)
            server.settimeout(None)
            _number(server)
            raise subprocess.TimeoutExpired(said, timeout, _text(out), _text(errors)) from None
        server.settimeout(None)
        done = subprocess.CompletedProcess(said, code, _text(out), _text(errors))
    assert not check or not code, done.stderr + done.stdout
    return done


@functools.cache
def _server() -> socket.socket:
    """A socket to the process that forks; it ends with this one."""
    here, there = socket.socketpair()
    with there:
        subprocess.Popen(
            [sys.executable, __file__, str(there.fileno())],
            pass_fds=[there.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},  # as the command sets it
        )
    return here


def _number(server: socket.socket) -> int:
    text = server.recv(NUMBER.size, socket.MSG_WAITALL)
    assert len(text) == NUMBER.size, "the process that starts commands has ended"
    return int(NUMBER.unpack(text)[0])


def _text(file: object) -> str:
    file.seek(0)  # type: ignore[attr-defined]
    return file.read().decode()  # type: ignore[attr-defined,no-any-return]


def serve(orders: socket.socket) -> None:
    """Fork a process for each order, and tell its process id and its exit code."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the test decides
    package = import_module("followspot")
    for name in (*(m.name for m in pkgutil.walk_packages(package.__path__, "followspot.")), *WARM):
        import_module(name)
    assert len(list(Path("/proc/self/task").iterdir())) == 1, "a fork would lose threads"
    gc.freeze()
    while True:
        size, outputs, _, _ = socket.recv_fds(orders, NUMBER.size, 2)
        if not size:
            return
        order = orders.recv(NUMBER.unpack(size)[0], socket.MSG_WAITALL)
        if (pid := os.fork()) == 0:
            orders.close()
            _become(outputs, *json.loads(order))
        for descriptor in outputs:
            os.close(descriptor)
        orders.sendall(NUMBER.pack(pid))
        orders.sendall(NUMBER.pack(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])))


def _become(outputs: list[int], words: list[str], folder: str, environment: dict[str, str]) -> NoReturn:
    """Be a process with this command, as a new interpreter would be."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number, descriptor in enumerate(outputs, 1):
        os.dup2(descriptor, number)
        os.close(descriptor)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[1:] = words
    code = 1
    try:
        code = import_module("followspot.cli.main").main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:  # as the interpreter does
        traceback.print_exc()
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    sys.path.pop(0)  # a command does not find what stands beside the tests
    serve(socket.socket(fileno=int(sys.argv[1])))

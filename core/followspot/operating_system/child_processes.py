"""Starts processes of this program that neither the terminal nor the present folder affects."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Sequence

_OF_TERMINALS = (signal.SIGINT, signal.SIGHUP)
"""Signals that a terminal sends to all processes of its group: at Ctrl-C, and when it closes."""


def module_command(module: str, *arguments: str) -> list[str]:
    """The command that runs a module of this program.

    `-P` keeps the present folder off the import path: a `random.py` there must not take the place of the
    module `random` of Python's library.
    """
    return [sys.executable, "-P", "-m", module, *arguments]


def start_apart(command: Sequence[str], descriptor: int) -> subprocess.Popen[bytes]:
    """Start a process that inherits a descriptor, in a process group of its own. Raises OSError.

    So Ctrl-C and a terminal that closes reach only the operator, which ends its workers. Signals of terminals
    are blocked during the start, because they would end the child before it has left the group.
    """
    held = signal.pthread_sigmask(signal.SIG_BLOCK, _OF_TERMINALS)
    try:
        return subprocess.Popen(command, pass_fds=[descriptor], stdin=subprocess.DEVNULL, process_group=0)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)


def ignore_terminal() -> None:
    """Ignore signals of terminals, also pending ones; a process of `start_apart` calls this first."""
    for number in _OF_TERMINALS:
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _OF_TERMINALS)

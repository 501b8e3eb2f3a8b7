"""Processes of this program: how they are started, apart from the terminal and the present folder."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Sequence

_OF_TERMINALS = (signal.SIGINT, signal.SIGHUP)
"""What a terminal sends to all processes of its group: Ctrl-C, and that it closes."""


def module_command(module: str, *arguments: str) -> list[str]:
    """Runs a module of this program.

    `-P` keeps the present folder off the path of imports: a `random.py` there, of an experiment or in a
    folder from elsewhere, must not take the place of the library's.
    """
    return [sys.executable, "-P", "-m", module, *arguments]


def start_apart(command: Sequence[str], descriptor: int) -> subprocess.Popen[bytes]:
    """Start a process in a group of its own, which inherits a descriptor: Ctrl-C and a terminal that closes
    reach the operator alone, which ends its workers. Raises OSError.

    The signals of terminals are blocked meanwhile: they would end the child before it has left the group.
    """
    held = signal.pthread_sigmask(signal.SIG_BLOCK, _OF_TERMINALS)
    try:
        return subprocess.Popen(command, pass_fds=[descriptor], stdin=subprocess.DEVNULL, process_group=0)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)


def ignore_terminal() -> None:
    """Ignore signals of terminals, pending ones too; a process of `start_apart` calls this first."""
    for number in _OF_TERMINALS:
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _OF_TERMINALS)

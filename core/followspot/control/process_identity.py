"""The identity of the process that operates a run, from which a host finds out whether it has died.

A host cannot tell a dead operator from one with an unplugged cable. An operator on the same machine can.
"""

from __future__ import annotations

import os
import pwd
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

_PROC = Path("/proc")
_MACHINE = Path("/etc/machine-id")
_BOOT = _PROC / "sys/kernel/random/boot_id"
_START_FIELD = 19
"""Index of the start time in `/proc/PID/stat`, counted after the name of the process."""


@dataclass(frozen=True)
class ProcessIdentity:
    """The identity of a process; an unknown field is "" or -1 and proves nothing.

    name: of the host in its certificate, "" without one; machine: machine id; boot: boot id; space: id of the
    PID namespace; pid: process id there; started: start time, ticks since the boot; user: that started it,
    for lists of runs.
    """

    name: str = ""
    machine: str = ""
    boot: str = ""
    space: str = ""
    pid: int = -1
    started: int = -1
    user: str = ""

    def dead(self, here: ProcessIdentity) -> bool:
        """True if this process has certainly died; here: the process that asks."""
        if self.boot and self.boot == here.boot:
            return self.space == here.space != "" and _started(self.pid) != self.started
        rebooted = self.boot and self.machine and self.machine == here.machine
        return bool(rebooted and self.name and self.name == here.name)  # a copied disk has the same id


def own_identity(name: str) -> ProcessIdentity:
    """The identity of this process; name: of the host in its certificate."""
    space = ""
    with suppress(OSError):
        space = str((_PROC / "self/ns/pid").readlink())
    pid = os.getpid()
    return ProcessIdentity(name, _text(_MACHINE), _text(_BOOT), space, pid, _started(pid), user_of(pid))


def user_of(pid: int) -> str:
    """The user of a process of this machine; "" if it does not exist, a number for a user without a name."""
    try:
        number = (_PROC / str(pid)).stat().st_uid
    except OSError:
        return ""
    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return str(number)


def _started(pid: int) -> int:
    """Start time of a process of this machine, ticks since the boot; -1 if it does not exist or has ended."""
    words = _text(_PROC / str(pid) / "stat").rpartition(")")[2].split()
    return -1 if not words or words[0] in "ZX" else int(words[_START_FIELD])


def _text(path: Path) -> str:
    try:
        return path.read_text(errors="replace").strip()
    except OSError:
        return ""

"""Which process of which machine operates a run, and whether it is certain that it has died.

Hosts cannot tell a dead operator from one whose cable is out. The next operator on the same machine can.
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

_PROC = Path("/proc")
_MACHINE = Path("/etc/machine-id")
_BOOT = _PROC / "sys/kernel/random/boot_id"
_STARTED = 19
"""Where the start of a process stands in its `stat`, after the name."""


@dataclass(frozen=True)
class Origin:
    """A process; what could not be found out is "" or -1, and proves nothing.

    name: of the host, as certified, "" without a certificate; machine: id of its installation; boot: of the
    start of its kernel; space: of the numbers of its processes; pid: number there; started: when, in ticks
    since the boot.
    """

    name: str = ""
    machine: str = ""
    boot: str = ""
    space: str = ""
    pid: int = -1
    started: int = -1

    def dead(self, here: Origin) -> bool:
        """Whether this process is known to have died; here: the one that asks."""
        if self.boot and self.boot == here.boot:
            return self.space == here.space != "" and _started(self.pid) != self.started
        again = self.boot and self.machine and self.machine == here.machine
        return bool(again and self.name and self.name == here.name)  # disks are copied, certificates are not


def own_origin(name: str) -> Origin:
    """That of this very process; name: as certified."""
    space = ""
    with suppress(OSError):
        space = str((_PROC / "self/ns/pid").readlink())
    pid = os.getpid()
    return Origin(name, _text(_MACHINE), _text(_BOOT), space, pid, _started(pid))


def _started(pid: int) -> int:
    """When a process of this machine was started, -1 where there is none of this number, or it has ended."""
    words = _text(_PROC / str(pid) / "stat").rpartition(")")[2].split()
    return -1 if not words or words[0] in "ZX" else int(words[_STARTED])


def _text(path: Path) -> str:
    try:
        return path.read_text(errors="replace").strip()
    except OSError:
        return ""

"""Processor time and memory of processes, as the kernel counts them: see proc(5)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

_TICK = os.sysconf("SC_CLK_TCK")
_SESSION, _PARENT = 5, 3
"""Words of /proc/PID/stat."""


class Memory(NamedTuple):
    """Of one process, MB: resident, its share of that if what several have is shared out, its own alone."""

    resident: float
    shared_out: float
    own: float


def family(leader: int) -> dict[int, int]:
    """The processes of a session, each with its parent."""
    return {int(words[0]): int(words[_PARENT]) for words in _processes() if int(words[_SESSION]) == leader}


def processor_time(leader: int) -> float:
    """Processor time of a session, s: of its processes, and of ended children that these have waited for."""
    ticks = [sum(map(int, words[13:17])) for words in _processes() if int(words[_SESSION]) == leader]
    return sum(ticks) / _TICK


def busy_time() -> float:
    """Processor time of all programs since the machine started, s."""
    first = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0]
    user, nice, system, _, _, irq, softirq = map(int, first.split()[1:8])
    return (user + nice + system + irq + softirq) / _TICK


def memory(leader: int) -> dict[int, Memory]:
    """Memory of a session's processes."""
    found = {}
    for pid in family(leader):
        with suppress(OSError, ValueError):  # it has just ended
            found[pid] = _memory_of(pid)
    return found


def _memory_of(pid: int) -> Memory:
    """Raises OSError or ValueError if there is no such process any more."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()[1:]
    sizes = {name: int(rest.split()[0]) / 1024 for name, _, rest in (line.partition(":") for line in lines)}
    if "Rss" not in sizes:
        raise ValueError(f"{pid} has ended")
    return Memory(sizes["Rss"], sizes["Pss"], sizes["Private_Clean"] + sizes["Private_Dirty"])


def _processes() -> Iterator[list[str]]:
    """The words of /proc/PID/stat of all processes; the name has no spaces any more."""
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with suppress(OSError):
                text = (folder / "stat").read_text(encoding="ascii", errors="replace")
                name_at, rest_at = text.index("("), text.rindex(")")
                yield [text[: name_at - 1], "name", *text[rest_at + 2 :].split()]

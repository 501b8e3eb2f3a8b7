"""Runs one contender in a session of its own, and measures all its processes from outside."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benching.peers.parts import READY, RESULT, START, Order

TOOLS = Path(__file__).parent.parent.parent
_LONGEST = 120.0
"""Seconds that a run may take to start, and to end."""
_HEAD_START = 0.2
"""Seconds from all parts being ready to the first frame set."""
_TICK = os.sysconf("SC_CLK_TCK")


class Figures(NamedTuple):
    """Of one run: frame sets per second, capture to track, and for a frame set; memory of all processes.

    others: cores that all other programs used meanwhile, on average.
    """

    per_second: float
    p50_ms: float
    p99_ms: float
    cpu_ms: float
    memory_mb: float
    others: float


class Told(NamedTuple):
    """What a run reports, its processor time, s, its memory, MB, and cores that other programs used."""

    report: dict[str, Any]
    cpu: float
    memory_mb: float
    others: float


class Stalled(RuntimeError):
    """A contender that lives and does not come to its end."""


def measured(order: Order, words: Sequence[str]) -> Figures:
    """Run a contender: a module of this package, and its options. Raises RuntimeError if it fails."""
    report, cpu, memory, others = told(order, words)
    p50, p99 = np.percentile(report["latencies_ms"], (50, 99))
    return Figures(report["per_second"], float(p50), float(p99), cpu * 1e3 / order.frames, memory, others)


def told(order: Order, words: Sequence[str], longest: float = _LONGEST) -> Told:
    """Run a contender. longest: seconds it may take to start, and to end. Raises RuntimeError, Stalled."""
    for file in Path(order.folder).iterdir():
        if file.suffix != ".npy":
            shutil.rmtree(file) if file.is_dir() else file.unlink()
    module, *rest = words
    command = [sys.executable, "-m", f"benching.peers.{module}", str(order.written()), *rest]
    environment = {**os.environ, "PYTHONPATH": str(TOOLS), "OPENBLAS_NUM_THREADS": "1"}
    log = order.path("log.txt").open("wb")
    with (
        log,
        subprocess.Popen(command, env=environment, start_new_session=True, stdout=log, stderr=log) as process,
    ):
        cameras = len(list(Path(order.folder).glob("*.npy")))
        try:
            wait(order, process, lambda: len(list(Path(order.folder).glob(f"{READY}*"))) == cameras, longest)
            begun = time.monotonic_ns()
            before, busy, memory = processor_time(process.pid), busy_time(), memory_mb(process.pid)
            draft = order.path("draft")
            draft.write_text(str(begun + round(_HEAD_START * 1e9)), encoding="utf-8")
            draft.rename(order.path(START))
            wait(order, process, order.path(RESULT).exists, longest)
            cpu, busy = processor_time(process.pid) - before, busy_time() - busy
            seconds = (time.monotonic_ns() - begun) / 1e9
        finally:
            end(process, _LONGEST / 10 if order.path(RESULT).exists() else 0.0)
    report = json.loads(order.path(RESULT).read_text(encoding="utf-8"))
    return Told(report, cpu, memory, max(0.0, busy - cpu) / seconds)


def wait(order: Order, process: subprocess.Popen[bytes], done: Callable[[], bool], longest: float) -> None:
    """Until it is done. Raises RuntimeError with what the contender printed if it ends before, or Stalled."""
    limit = time.monotonic() + longest
    while not done():
        ended = process.poll() is not None
        if ended or time.monotonic() > limit:
            printed = order.path("log.txt").read_text(encoding="utf-8", errors="replace")
            ready = len(list(Path(order.folder).glob(f"{READY}*")))
            text = f"{process.args!r} did not come to its end; {ready} cameras were ready:\n{printed[-3000:]}"
            raise RuntimeError(text) if ended else Stalled(text)
        time.sleep(0.02)


def end(process: subprocess.Popen[bytes], longest: float) -> None:
    """Wait for its end, at most so many seconds; kill what is left of its processes."""
    with suppress(subprocess.TimeoutExpired):
        process.wait(longest)
    for pid in family(process.pid):
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def family(leader: int) -> list[int]:
    """The processes of a session."""
    return [int(words[0]) for words in processes() if int(words[5]) == leader]


def processor_time(leader: int) -> float:
    """That of a session's processes, s, with those that ended and whose parents are still there."""
    ticks = [sum(map(int, words[13:17])) for words in processes() if int(words[5]) == leader]
    return sum(ticks) / _TICK


def busy_time() -> float:
    """Processor time of all programs since the machine started, s; see proc(5)."""
    first = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0]
    user, nice, system, _, _, irq, softirq = map(int, first.split()[1:8])
    return (user + nice + system + irq + softirq) / _TICK


def memory_mb(leader: int) -> float:
    """Memory of a session's processes, MB; each has its share of what it has in common with others."""
    found = 0.0
    for pid in family(leader):
        with suppress(OSError):
            rollup = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii")
            found += next(int(line.split()[1]) for line in rollup.splitlines() if line.startswith("Pss:"))
    return found / 1024


def processes() -> Iterator[list[str]]:
    """The words of /proc/PID/stat of all processes: see proc(5); the name has no spaces any more."""
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with suppress(OSError):
                text = (folder / "stat").read_text(encoding="ascii", errors="replace")
                name_at, rest_at = text.index("("), text.rindex(")")
                yield [text[: name_at - 1], "name", *text[rest_at + 2 :].split()]

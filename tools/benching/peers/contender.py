"""Runs one contender in a session of its own, and measures all its processes from outside."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benching.peers.parts import READY, RESULT, START, Order
from benching.processes import busy_time, family, memory, processor_time

TOOLS = Path(__file__).parent.parent.parent
_LONGEST = 120.0
"""Seconds that a run may take to start, and to end."""
_HEAD_START = 0.2
"""Seconds from all parts being ready to the first frame set."""


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
    report, cpu, taken, others = told(order, words)
    p50, p99 = np.percentile(report["latencies_ms"], (50, 99))
    return Figures(report["per_second"], float(p50), float(p99), cpu * 1e3 / order.frames, taken, others)


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
            before, busy = processor_time(process.pid), busy_time()
            taken = sum(found.shared_out for found in memory(process.pid).values())
            draft = order.path("draft")
            draft.write_text(str(begun + round(_HEAD_START * 1e9)), encoding="utf-8")
            draft.rename(order.path(START))
            wait(order, process, order.path(RESULT).exists, longest)
            cpu, busy = processor_time(process.pid) - before, busy_time() - busy
            seconds = (time.monotonic_ns() - begun) / 1e9
        finally:
            end(process, _LONGEST / 10 if order.path(RESULT).exists() else 0.0)
    report = json.loads(order.path(RESULT).read_text(encoding="utf-8"))
    return Told(report, cpu, taken, max(0.0, busy - cpu) / seconds)


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

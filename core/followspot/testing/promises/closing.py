"""Promises about the close of a stage: it works at any time, is quick, and leaves nothing behind."""

from __future__ import annotations

import gc
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from followspot.testing.trial import Trial, reason


def closes_without_setup(trial: Trial) -> Iterator[str]:
    """A run that is called off closes stages that were never set up."""
    yield from _closed(trial, setup=False, times=1)


def closes_twice(trial: Trial) -> Iterator[str]:
    """After an error a stage may be closed again."""
    yield from _closed(trial, setup=not trial.ports.source, times=2)


def closes_within_a_second(trial: Trial) -> Iterator[str]:
    """Ctrl-C waits for every stage; a thread or a peer that does not answer must not hold up the others."""
    if not trial.computes:
        return
    try:
        with trial.at_work() as stage:
            trial.feed(stage, range(3))
            started = time.monotonic()
    except Exception:
        return  # the promises about `process` report it
    if time.monotonic() - started > 1.0:
        yield f"close takes {time.monotonic() - started:.1f} s"


def leaves_no_thread_behind(trial: Trial) -> Iterator[str]:
    """`close` ends everything that `setup` starts."""
    before = set(threading.enumerate())
    _work(trial, 3)
    left = [thread.name for thread in set(threading.enumerate()) - before if thread.is_alive()]
    if left:
        yield f"threads go on after close: {', '.join(sorted(left))}"


def leaves_no_file_open(trial: Trial) -> Iterator[str]:
    """Files and sockets are closed by `close`, not by chance."""
    folder = Path("/proc/self/fd")
    if not folder.is_dir() or not trial.computes:
        return
    _work(trial, 1)  # modules and files that the first call opens for good do not count
    gc.disable()
    try:
        before = len(list(folder.iterdir()))
        _work(trial, 1)
        if len(list(folder.iterdir())) > before:
            yield "a file or socket is still open after close"
    finally:
        gc.enable()


def _closed(trial: Trial, *, setup: bool, times: int) -> Iterator[str]:
    """The error that `close` raises if it is called this many times."""
    if not trial.buildable:
        return
    with tempfile.TemporaryDirectory(prefix="followspot-") as folder:
        stage = trial.build(Path(folder))
        try:
            if setup:
                stage.setup()
            for _ in range(times):
                stage.close()
        except Exception as error:
            yield f"close raises {reason(error)}"


def _work(trial: Trial, frames: int) -> None:
    """Set a stage up, feed it and close it. The promises about `process` report its errors."""
    if not trial.computes:
        return
    try:
        with trial.at_work() as stage:
            trial.feed(stage, range(frames))
    except Exception:
        return

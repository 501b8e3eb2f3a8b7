"""Promises about setup, state and close of a stage."""

from __future__ import annotations

import gc
import importlib
import logging
import mmap
import multiprocessing
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from followspot.stage import Stage
from followspot.testing.promises.work import contents
from followspot.testing.trial import Trial, noise, outputs, reason

GROWTH = 8 << 20
"""Bytes that a stage may grow by while it handles a third of many messages."""
CACHED = 64
"""Objects that numpy and Python keep for reuse meanwhile; how many differs from machine to machine."""
TIMEOUT = 60.0
"""Seconds for a fresh process to import a stage."""


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
            _feed(trial, stage, range(3))
            started = time.monotonic()
    except Exception:
        return  # others say so
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
    _work(trial, 1)  # what the first call imports and opens for good
    gc.disable()
    try:
        before = len(list(folder.iterdir()))
        _work(trial, 1)
        if len(list(folder.iterdir())) > before:
            yield "a file or socket is still open after close"
    finally:
        gc.enable()


def has_a_state_of_plain_values(trial: Trial) -> Iterator[str]:
    """The state goes to a successor in another process: numbers, text, arrays, lists and dicts."""
    if not trial.computes:
        return
    try:
        with trial.at_work() as stage:
            _feed(trial, stage, range(3))
            wrong = _not_plain(stage.state())
    except Exception:
        return  # others say so
    if wrong is not None:
        yield f"state() holds a {type(wrong).__name__}, which does not travel"


def carries_on_from_its_state(trial: Trial) -> Iterator[str]:
    """A replacement with the checkpoint of the old stage gives the same results, bit for bit.

    It has the random numbers of the old one, as `followspot verify` gives it. What `state_lacks` names may
    change the results.
    """
    if not trial.computes or trial.stage.state is Stage.state:
        return
    try:
        with trial.at_work() as first, trial.at_work() as second:
            _feed(trial, first, range(2))
            second.restore(first.state())  # a swap tries it first
            _feed(trial, first, range(2, 4))
            second.restore(first.state())
            if "rng" in first.__dict__:
                second.rng.bit_generator.state = first.rng.bit_generator.state
            for n in range(4, 7):
                inputs = trial.inputs("plausible", n, noise(n))
                pairs = zip(*(outputs(trial.called(stage, inputs)) for stage in (first, second)), strict=True)
                same = all(contents(a) == contents(b) for a, b in pairs)
                if not (same or trial.stage.state_lacks):
                    yield f"{n - 3} frames after the hand-over the successor gives something else"
                    return
    except Exception as error:
        yield f"the hand-over raises {reason(error)}"


def keeps_its_memory(trial: Trial) -> Iterator[str]:
    """A show lasts hours: many messages leave no trace, neither objects nor memory.

    What a stage keeps for each message grows all the time, and what it keeps once does not: of two thirds of
    the messages, the one that left less counts.
    """
    if not trial.computes or trial.messages < 3:
        return
    third = trial.messages // 3
    frames = [trial.inputs("plausible", n, noise(n)) for n in range(8)]
    frozen = gc.get_freeze_count()  # by the caller, whose objects stay frozen
    gc.freeze()  # a collection then looks only at what is new
    disabled = logging.root.manager.disable
    logging.disable()  # pytest keeps what is logged
    try:
        with trial.at_work() as stage:
            sizes = []
            for _ in range(3):
                for n in range(third):
                    trial.called(stage, frames[n % len(frames)])
                gc.collect()
                sizes.append((sys.getallocatedblocks(), _resident()))
    except Exception:
        return  # others say so
    finally:
        logging.disable(disabled)
        if not frozen:
            gc.unfreeze()
    objects, size = (min(later - sooner for sooner, later in pairwise(of)) for of in zip(*sizes, strict=True))
    if objects > CACHED + third // 2:
        yield f"it keeps {objects / third:.1f} objects a message"
    if size > GROWTH:
        yield f"it grows by {size / third:.0f} bytes a message"


def _resident() -> int:
    """Memory of this process, bytes; 0 if the system does not report it."""
    statistics = Path("/proc/self/statm")
    return int(statistics.read_text().split()[1]) * mmap.PAGESIZE if statistics.exists() else 0


def starts_in_a_fresh_process(trial: Trial) -> Iterator[str]:
    """A worker imports the stage with nothing but the runtime imported before."""
    stage = trial.stage
    file = sys.modules[stage.__module__].__file__
    if stage.__module__ == "__main__" or "<locals>" in stage.__qualname__ or file is None:
        return  # is_found_by_its_name says so
    if error := _import_error(stage.__module__):
        yield f"a fresh process cannot import it: {error}"


@cache
def _import_error(module: str) -> str:
    """What a new process says that cannot import a module; empty if it can.

    The process has what every worker has imported before it looks for stages, and nothing else.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["followspot.worker.main"])
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_import, args=(module, there), daemon=True)
    with _without_main():
        process.start()
    there.close()
    try:
        return str(here.recv()) if here.poll(TIMEOUT) else f"not done after {TIMEOUT:g} s"
    except EOFError:
        return "the process ended"
    finally:
        process.kill()
        process.join()


@contextmanager
def _without_main() -> Iterator[None]:
    """Let a process that starts meanwhile not run the script of this one, which may have no guard."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _import(module: str, answer: Connection) -> None:
    """Tell what the import of a module raises."""
    try:
        importlib.import_module(module)
    except BaseException as error:
        answer.send(reason(error))
    else:
        answer.send("")


def _closed(trial: Trial, *, setup: bool, times: int) -> Iterator[str]:
    """What `close` raises if it is called so often."""
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
    """Set a stage up, feed it and close it. Its errors are left to the promises about its work."""
    if not trial.computes:
        return
    try:
        with trial.at_work() as stage:
            _feed(trial, stage, range(frames))
    except Exception:
        return


def _feed(trial: Trial, stage: Stage, frames: range) -> None:
    for n in frames:
        trial.called(stage, trial.inputs("plausible", n, noise(n)))


def _not_plain(value: Any) -> Any:
    """The first part that is no number, text, array, list or dict; None if all are."""
    if value is None or isinstance(value, bool | int | float | str | bytes | np.generic):
        return None
    if isinstance(value, np.ndarray):
        return None if value.dtype.kind in "biufcSU" else value
    if isinstance(value, list | tuple):
        return next((wrong for item in value if (wrong := _not_plain(item)) is not None), None)
    if isinstance(value, Mapping):
        return next(
            (wrong for item in (*value, *value.values()) if (wrong := _not_plain(item)) is not None), None
        )
    return value

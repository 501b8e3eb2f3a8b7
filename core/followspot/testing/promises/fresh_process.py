"""The promise that a stage can be imported in a new process."""

from __future__ import annotations

import importlib
import multiprocessing
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from multiprocessing.connection import Connection
from types import ModuleType

from followspot.testing.trial import Trial, reason

TIMEOUT = 60.0
"""Seconds for a fresh process to import a stage."""


def starts_in_a_fresh_process(trial: Trial) -> Iterator[str]:
    """A worker imports the stage when it has imported nothing but the runtime."""
    stage = trial.stage
    file = sys.modules[stage.__module__].__file__
    if stage.__module__ == "__main__" or "<locals>" in stage.__qualname__ or file is None:
        return  # `is_found_by_its_name` reports it
    if error := _import_error(stage.__module__):
        yield f"a fresh process cannot import it: {error}"


@cache
def _import_error(module: str) -> str:
    """The error of a new process that imports a module; empty if it succeeds.

    The process has imported what every worker imports before its stages, and nothing else.
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
    """Keep processes that start in this block from running this process's script, which may have no guard."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _import(module: str, answer: Connection) -> None:
    """Send the error that the import of a module raises; empty if it raises none."""
    try:
        importlib.import_module(module)
    except BaseException as error:
        answer.send(reason(error))
    else:
        answer.send("")

"""What a command that changes a run waits for, told on standard error while it waits."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from followspot.cli.agent_options import network_of
from followspot.errors import FollowspotError
from followspot.library.handle import NoAnswer, RunHandle, connected_run

_FIRST = 2.0
"""Seconds that a command takes before it tells what it waits for."""
_NEXT = 5.0
"""Seconds between two lines after that."""
_ANSWER = 1.0
"""Seconds that the run has to say what its change waits for."""
_FAULTS = 3
"""Faults of a run that are told at most."""


@contextmanager
def patient_run(args: argparse.Namespace) -> Iterator[RunHandle]:
    """The run that the options name, as `connected_run` finds it; a line now and then while the block lasts.

    Raises FollowspotError if there is no such run, or several.
    """
    found: list[RunHandle] = []

    def what() -> str:
        return awaited(found[0]) if found else "the runs in reach to answer"

    with telling(what), connected_run(args.run, network_of(args)) as run:
        found.append(run)
        yield run


@contextmanager
def telling(what: Callable[[], str], first: float = _FIRST, following: float = _NEXT) -> Iterator[None]:
    """Tell on standard error what the block waits for.

    first: s until the first line; following: s between two lines after that.
    """
    over = Event()
    began = time.monotonic()

    def tell() -> None:
        pause = first
        while not over.wait(pause):
            line = what()
            if not over.is_set():
                since = time.monotonic() - began
                print(f"followspot: waiting for {line} ({since:.0f} s so far)", file=sys.stderr, flush=True)
            pause = following

    thread = Thread(target=tell, name="patience", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join(_ANSWER)


def awaited(run: RunHandle) -> str:
    """What a request to the run waits for, with the faults of the run."""
    try:
        status = run.status(_ANSWER)
    except NoAnswer as error:
        return f"an answer: {error}"
    except FollowspotError:
        return f"{run.label} to answer"
    return "; ".join([status.change_awaits or f"{run.label} to answer", *status.faults()[:_FAULTS]])

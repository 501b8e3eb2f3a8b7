"""Notices on standard error about what a command waits for, for commands that change a run."""

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
"""Seconds before the first line."""
_NEXT = 5.0
"""Seconds between later lines."""
_ANSWER = 1.0
"""Seconds that the run has to answer what its change waits for."""
_FAULTS = 3
"""Most faults of a run in a line."""


@contextmanager
def run_with_notices(args: argparse.Namespace) -> Iterator[RunHandle]:
    """The run that the options name, as `connected_run` finds it, with notices while the block waits.

    Under agents the command leads the change itself, and undoes it on KeyboardInterrupt. Raises
    FollowspotError if there is no such run, or several.
    """
    found: list[RunHandle] = []

    def what() -> str:
        return pending_of(found[0]) if found else "the runs in reach to answer"

    with wait_notices(what), connected_run(args.run, network_of(args)) as run:
        found.append(run)
        try:
            yield run
        except KeyboardInterrupt:
            if run.pid is not None:
                line = f"{run.label} still does what it was asked to; followspot top shows it"
                print(f"\nfollowspot: {line}", file=sys.stderr)
            raise


@contextmanager
def wait_notices(what: Callable[[], str], first: float = _FIRST, following: float = _NEXT) -> Iterator[None]:
    """Print on standard error what the block waits for.

    what: called for each line; first: s until the first line; following: s between later lines.
    """
    over = Event()
    began = time.monotonic()

    def notify() -> None:
        pause = first
        while not over.wait(pause):
            line = what()
            if not over.is_set():
                since = time.monotonic() - began
                print(f"followspot: waiting for {line} ({since:.0f} s so far)", file=sys.stderr, flush=True)
            pause = following

    thread = Thread(target=notify, name="wait notices", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join(_ANSWER)


def pending_of(run: RunHandle) -> str:
    """The text of a notice: what a request to the run waits for, and the faults of the run."""
    try:
        status = run.status(_ANSWER)
    except NoAnswer as error:
        return f"an answer: {error}"
    except FollowspotError:
        return f"{run.label} to answer"
    return "; ".join([status.change_awaits or f"{run.label} to answer", *status.faults()[:_FAULTS]])

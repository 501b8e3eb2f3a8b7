"""Starts and ends the process of a flight recorder."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from followspot.errors import FollowspotError
from followspot.library.handle import run_here
from followspot.operating_system.child_processes import module_command
from followspot_record.flight.order import FlightEnd, FlightOrder

_WRITING = 300.0
"""Seconds that the last files may take after the end of the run."""


class RunningRecorder:
    """A flight recorder at work. lines: its output at the end, a line for each file."""

    def __init__(self) -> None:
        self.lines: tuple[str, ...] = ()
        self._errors: tuple[str, ...] = ()

    def failed(self, errors: Sequence[str]) -> None:
        """The run failed, with these errors: its last seconds are saved."""
        self._errors = tuple(errors)

    @property
    def end(self) -> FlightEnd:
        """The order that ends the process, at the end of the run."""
        return FlightEnd(errors=self._errors)


@contextmanager
def running_recorder(order: FlightOrder) -> Iterator[RunningRecorder]:
    """Keep the last seconds of a run while the block runs; all files are complete after it."""
    process = subprocess.Popen(
        module_command("followspot_record.flight.process"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C ends the run, and the run ends its recorder
    )
    assert process.stdin is not None
    with suppress(BrokenPipeError):
        process.stdin.write(order.model_dump_json() + "\n")
        process.stdin.flush()
    found, over = RunningRecorder(), threading.Event()
    threading.Thread(target=_watch, args=(process, order.run, over), daemon=True).start()
    try:
        yield found
    finally:
        over.set()
        try:
            said, _ = process.communicate(found.end.model_dump_json() + "\n", timeout=_WRITING)
            found.lines = tuple(said.splitlines())
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _watch(process: subprocess.Popen[str], run: str, over: threading.Event) -> None:
    """Say it if the process ends before its run, which takes no marks then."""
    process.wait()
    if not over.is_set():
        with suppress(FollowspotError):
            run_here(run).exchange_marks(None, 0)
        line = (
            "followspot: warning: the flight recorder has ended; the run goes on, and nothing of it is kept"
        )
        print(line, file=sys.stderr, flush=True)

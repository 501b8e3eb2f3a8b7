"""`followspot logs`: print the log of a run that goes on or has ended."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path

from followspot.cli.agent_options import network_of
from followspot.errors import FollowspotError, InputError
from followspot.frame_times import to_seconds
from followspot.graph.names import enclosing
from followspot.library.handle import LEVELS, LogRecord, RunHandle, connected_run, read_log

_PERIOD = 0.3
"""Seconds between two requests for new records."""


def logs(args: argparse.Namespace) -> int:
    """Print the chosen records; with --follow until the run ends or Ctrl-C. Returns the exit code."""
    wanted = _filter(args)
    show = _as_json if args.json else as_text
    if args.run is not None and Path(args.run).is_dir():
        if args.follow:
            raise FollowspotError(f"{args.run} is the output folder of a run; -f needs a run that goes on")
        _print(read_log(Path(args.run)), wanted, show)
        return 0
    with connected_run(args.run, network_of(args)) as run:
        try:
            _print(_records(run, follow=args.follow), wanted, show)
        except KeyboardInterrupt:
            return 0
    return 0


def as_text(record: LogRecord) -> str:
    """A record as text: time, level, host and worker, stage, text; further lines are indented."""
    when = time.strftime("%H:%M:%S", time.localtime(to_seconds(record.time)))
    where = "/".join(part for part in (record.host, record.worker) if part)
    whose = " ".join(part for part in (where, record.stage) if part)
    head = f"{when}.{record.time // 1_000_000 % 1000:03d} {record.level:7} {whose}".rstrip()
    return f"{head}: " + record.text.strip().replace("\n", "\n    ")


def _as_json(record: LogRecord) -> str:
    return json.dumps(record.to_data())


def _records(run: RunHandle, *, follow: bool) -> Iterator[LogRecord]:
    """All records so far; if `follow`, also new records until the run ends."""
    out = run.metadata().out if follow else None
    last = -1
    while True:
        over = follow and run.over()
        try:
            page = run.log(last)
        except FollowspotError:
            if out is None:
                raise
            with suppress(InputError):  # there is no file if the log is empty
                yield from islice(read_log(out), last + 1, None)  # the last records
            return
        yield from page.records
        last = page.last
        if not page.records:
            if over or not follow:
                return
            time.sleep(_PERIOD)


def _print(
    records: Iterable[LogRecord], wanted: Callable[[LogRecord], bool], show: Callable[[LogRecord], str]
) -> None:
    for record in records:
        if wanted(record):
            print(show(record), flush=True)


def _filter(args: argparse.Namespace) -> Callable[[LogRecord], bool]:
    """A test for records that the options choose; a stage means all its cameras."""
    least = LEVELS.index(args.level)

    def wanted(record: LogRecord) -> bool:
        return (
            LEVELS.index(record.level) >= least
            and args.stage in (None, *enclosing(record.stage))
            and args.worker in (None, record.worker)
            and args.host in (None, record.host)
        )

    return wanted

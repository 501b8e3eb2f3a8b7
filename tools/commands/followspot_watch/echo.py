"""`followspot echo`: print the messages of a port of a run."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import suppress
from itertools import islice
from typing import Any

from followspot import Room
from followspot.cli.agent_options import network_of
from followspot.frame_times import to_seconds
from followspot.library.handle import RunHandle, connected_run
from followspot.message_table import as_json, rows_of, table_of
from followspot.messages import Message, stamped
from followspot.plugins.registry import use_plugin_files
from followspot.tables.table_column import TableColumn
from followspot.tables.terminal import table
from followspot.tracking import Frame
from followspot_dashboard.picture import Picture
from followspot_watch.run_monitor import RunMonitor
from followspot_watch.tap_subscriber import TapSubscriber, tapped_ports

SINK = "dashboard.echo"
_PERIOD = 0.5
"""Seconds between two checks whether the run has ended."""
_ROWS = 6
"""Rows of a message that the text shows."""
_WIDEST = 60
"""Characters of a cell that the text shows."""


def echo(args: argparse.Namespace) -> int:
    """Print messages as they come, until enough came, the run ends, or Ctrl-C. Returns the exit code."""
    use_plugin_files(args.plugin_files)
    with connected_run(args.run, network_of(args)) as run:
        known = tapped_ports(args.port, run)
        sent = {name: Picture if kind is Frame else kind for name, kind in known.items()}
        with TapSubscriber(run, sent, SINK) as subscriber, suppress(KeyboardInterrupt):
            _print(subscriber, args, Warner(run), run.plan().room)
    return 0


class Warner:
    """Reports on standard error which hosts and workers are absent or silent when no messages come."""

    def __init__(self, run: RunHandle) -> None:
        self._run = run
        self._picture = RunMonitor(run.plan())
        self._reported = False

    def warn(self) -> None:
        """No message came for a while: report faults that were not reported yet."""
        self._picture.renew(lambda: self._run.status(_PERIOD))
        faults = self._picture.faults()
        if bool(faults) != self._reported:
            self._reported = bool(faults)
            for line in faults or ["all hosts and workers answer again"]:
                print(f"followspot: {line}", file=sys.stderr, flush=True)


def _print(subscriber: TapSubscriber, args: argparse.Namespace, warner: Warner, room: Room) -> None:
    left, came = args.number, True
    for received in subscriber.messages(_PERIOD):
        if received is None:
            if not came:
                warner.warn()
            came = False
            continue
        came = True
        show = (lambda *given: json.dumps(data(*given))) if args.json else text
        print(show(*received, room), flush=True)
        left -= 1
        if left == 0:
            return


def data(port: str, message: Message, room: Room) -> dict[str, Any]:
    """A message in JSON types, with the names of `followspot.message_table`; of a picture only the size."""
    if isinstance(message, Picture):
        message = stamped(message.where(slice(0)), message.header)
    return {"port": port, **as_json(message, room)}


def text(port: str, message: Message, room: Room) -> str:
    """A message as text: single values, then its table."""
    header = message.header
    lines = [
        f"{port}  {type(message).__name__}  {header.source}#{header.seq}  {to_seconds(header.time):.6f} s"
    ]
    lines += [f"  {name} {getattr(message, name)!r}" for name, _ in message.scalars]
    if isinstance(message, Picture):
        return "\n".join(lines)
    cells = [one for one in table_of(message, room) if one.name not in dict(message.scalars)]
    rows = list(islice(rows_of(cells), _ROWS + 1))
    if rows:
        texts = [[_cell(value) for value in row] for row in rows[:_ROWS]]
        lines += [table([_head(one) for one in cells], texts), *["  ..."] * (len(rows) > _ROWS)]
    return "\n".join(lines)


def _head(cells: TableColumn) -> str:
    return cells.name if cells.unit == "1" else f"{cells.name} [{cells.unit}]"


def _cell(value: Any) -> str:
    return f"{value:.4f}" if isinstance(value, float) else str(value)[:_WIDEST]

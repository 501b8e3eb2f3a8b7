"""`followspot echo`: print the messages of a port of a run."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from followspot.cli.agent_options import network_of
from followspot.library.handle import RunHandle, connected_run
from followspot.messages import Array, Message
from followspot.plugins.registry import use_plugin_files
from followspot.tracking import Frame
from followspot_dashboard.picture import Picture
from followspot_watch.run_monitor import RunMonitor
from followspot_watch.tap_subscriber import TapSubscriber, subscribed, tapped_ports

SINK = "dashboard.echo"
_PERIOD = 0.5
"""Seconds between two checks whether the run has ended."""
_ROWS = 6
"""Rows of an array that the text shows."""


def echo(args: argparse.Namespace) -> int:
    """Print messages as they come, until enough came, the run ends, or Ctrl-C. Returns the exit code."""
    use_plugin_files(args.plugin_files)
    with connected_run(args.run, network_of(args)) as run:
        ports = [
            replace(port, type=Picture if port.type is Frame else port.type)
            for port in tapped_ports(args.port, run)
        ]
        with subscribed(run, ports, SINK) as subscriber, suppress(KeyboardInterrupt):
            _print(subscriber, args, Warner(run))
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


def _print(subscriber: TapSubscriber, args: argparse.Namespace, warner: Warner) -> None:
    left, came = args.number, True
    for received in subscriber.messages(_PERIOD):
        if received is None:
            if not came:
                warner.warn()
            came = False
            continue
        came = True
        print(json.dumps(data(*received)) if args.json else text(*received), flush=True)
        left -= 1
        if left == 0:
            return


def data(port: str, message: Message) -> dict[str, Any]:
    """A message in JSON types. NaN and infinity become null; of a picture there is only the size."""
    header = message.header
    fields: dict[str, Any] = {name: getattr(message, name) for name, _ in message.scalars}
    if not isinstance(message, Picture):
        fields |= {column.name: _plain(getattr(message, column.name)) for column in message.columns}
    about = {"port": port, "source": header.source, "seq": header.seq, "time": header.time}
    return {**about, "type": type(message).__name__, **fields}


def text(port: str, message: Message) -> str:
    """A message as text."""
    header = message.header
    lines = [f"{port}  {type(message).__name__}  {header.source}#{header.seq}  {header.time / 1e9:.6f} s"]
    lines += [f"  {name} {getattr(message, name)!r}" for name, _ in message.scalars]
    for column in message.columns:
        array = getattr(message, column.name)
        if not isinstance(message, Picture) and array.size:
            shown = np.array2string(array[:_ROWS], precision=4, suppress_small=True, prefix=" " * 4)
            more = f"  ... {len(array)} rows" if len(array) > _ROWS else ""
            lines.append(f"  {column.name} [{column.unit}] {array.shape}\n    {shown}{more}")
    return "\n".join(lines)


def _plain(array: Array) -> Any:
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        return np.where(np.isfinite(array), array, None).tolist()  # type: ignore[call-overload]
    return array.tolist()

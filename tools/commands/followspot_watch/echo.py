"""`followspot echo`: the messages of a port of a graph that runs."""

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
from followspot_watch.picture_of_run import RunPicture
from followspot_watch.tap_subscriber import TapSubscriber, chosen, listening

SINK = "dashboard.echo"
_PERIOD = 0.5
"""Seconds between two looks whether the run has ended."""
_ROWS = 6
"""Rows of an array that are shown to people."""


def echo(args: argparse.Namespace) -> int:
    """Print messages as they come, until enough came, the run ends, or Ctrl-C. Returns the exit code."""
    use_plugin_files(args.plugin_files)
    with connected_run(args.run, network_of(args)) as run:
        heard = [
            replace(port, type=Picture if port.type is Frame else port.type)
            for port in chosen(args.port, run)
        ]
        with listening(run, heard, SINK) as ear, suppress(KeyboardInterrupt):
            _print(ear, args, Warner(run))
    return 0


class Warner:
    """Says on standard error why nothing comes, where something is absent or was not heard lately."""

    def __init__(self, run: RunHandle) -> None:
        self._run = run
        self._picture = RunPicture(run.plan())
        self._said = False

    def warn(self) -> None:
        """Nothing came for a while; what is wrong is told once."""
        self._picture.renew(lambda: self._run.status(_PERIOD))
        faults = self._picture.faults()
        if bool(faults) != self._said:
            self._said = bool(faults)
            for line in faults or ["all is heard again"]:
                print(f"followspot: {line}", file=sys.stderr, flush=True)


def _print(ear: TapSubscriber, args: argparse.Namespace, warner: Warner) -> None:
    left, came = args.number, True
    for heard in ear.heard(_PERIOD):
        if heard is None:
            if not came:
                warner.warn()
            came = False
            continue
        came = True
        print(json.dumps(data(*heard)) if args.json else text(*heard), flush=True)
        left -= 1
        if left == 0:
            return


def data(port: str, message: Message) -> dict[str, Any]:
    """A message in JSON types; numbers that are none are null, and of pictures only the size is told."""
    header = message.header
    fields: dict[str, Any] = {name: getattr(message, name) for name, _ in message.scalars}
    if not isinstance(message, Picture):
        fields |= {column.name: _plain(getattr(message, column.name)) for column in message.columns}
    about = {"port": port, "source": header.source, "seq": header.seq, "time": header.time}
    return {**about, "type": type(message).__name__, **fields}


def text(port: str, message: Message) -> str:
    """A message for people."""
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

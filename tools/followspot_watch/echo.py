"""`followspot echo`: the messages of a port of a graph that runs."""

from __future__ import annotations

import argparse
import json
import selectors
import socket
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from followspot.errors import FollowspotError, did_you_mean
from followspot.graph.plan import Plan
from followspot.messages import Array, InvalidMessage, Message
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot.runtime.tapping import Tapping
from followspot.tracking import Frame
from followspot.wire import unpack
from followspot_dashboard.gate import make_gate
from followspot_dashboard.line import SOCKET, read
from followspot_dashboard.picture import Picture
from followspot_watch.runs import plan_here, run_here

TAP = "dashboard.tap"
_BUFFER = 1 << 18
_PATIENCE = 10.0
_ROWS = 6
"""Rows of an array that are shown to people."""


def echo(args: argparse.Namespace) -> int:
    """Print messages as they come, until enough came, the run ends, or Ctrl-C. Returns the exit code."""
    run = run_here(args.run)
    plan = plan_here(run)
    kinds = chosen(args.port, plan)
    with (
        TemporaryDirectory(prefix="followspot-echo-") as made,
        socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as door,
    ):
        folder = Path(made)
        make_gate(folder).watched = True
        door.bind(str(folder / SOCKET))
        door.listen(len(kinds))
        params = {"folder": str(folder), "every": True}
        taps = [asdict(Tapping(port, TAP, {**params, "port": port})) for port in kinds]
        run.ask("tap", _PATIENCE, taps=taps)
        left = args.number
        try:
            for port, message in _messages(door, kinds):
                print(json.dumps(data(port, message)) if args.json else text(port, message), flush=True)
                left -= 1
                if left == 0:
                    break
        except KeyboardInterrupt:
            pass
    return 0


def chosen(word: str, plan: Plan) -> Mapping[str, type[Message]]:
    """The ports that a word names, with what they send. Raises FollowspotError where there is none.

    color/cam0.out is called color, color/cam0 and color.out, too.
    """
    near = {worker.name for worker in plan.workers if not worker.host}
    known = {
        f"{stage.name}.{port.name}": port.type
        for stage in plan.stages
        if stage.worker in near
        for port in ports(load_stage(stage.uses)).outputs
    }
    found = {port: _sent(kind) for port, kind in known.items() if word in _names(port)}
    if not found:
        remedy = did_you_mean(word, {name for port in known for name in _names(port)}, "ports")
        raise FollowspotError(f'there is no port "{word}" on this machine; {remedy}')
    return found


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


def _messages(door: socket.socket, kinds: Mapping[str, type[Message]]) -> Iterator[tuple[str, Message]]:
    """What the taps send, until the last of them is gone."""
    with selectors.DefaultSelector() as selector:
        selector.register(door, selectors.EVENT_READ)
        waiting = len(kinds)
        while waiting:
            for key, _ in selector.select():
                if key.fileobj is door:
                    selector.register(door.accept()[0], selectors.EVENT_READ)
                    continue
                assert isinstance(key.fileobj, socket.socket)
                packet = key.fileobj.recv(_BUFFER)
                if packet:
                    yield from _unpacked(packet, kinds)
                    continue
                selector.unregister(key.fileobj)
                key.fileobj.close()
                waiting -= 1


def _unpacked(packet: bytes, kinds: Mapping[str, type[Message]]) -> Iterator[tuple[str, Message]]:
    try:
        port, _, packed = read(packet)
        message = unpack(packed, kinds[port])
    except (InvalidMessage, ValueError, KeyError):
        return
    if isinstance(message, Message):
        yield port, message


def _sent(kind: type[Message]) -> type[Message]:
    return Picture if kind is Frame else kind


def _plain(array: Array) -> Any:
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        return np.where(np.isfinite(array), array, None).tolist()  # type: ignore[call-overload]
    return array.tolist()


def _names(port: str) -> tuple[str, str, str, str]:
    stage, _, name = port.rpartition(".")
    group = stage.partition("/")[0]
    return group, stage, f"{group}.{name}", port

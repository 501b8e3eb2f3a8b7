"""The recorder of a graph that runs, a process of its own: `python -m followspot_record.recorder_process`.

Its first line of standard input is an order, JSON; "stop" ends the recording at once, the end of the input as
soon as all who send have left. A line of JSON on standard output says now and then what has been recorded.
"""

from __future__ import annotations

import json
import socket
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from followspot import Context, Message
from followspot.errors import FollowspotError
from followspot.messages import InvalidMessage
from followspot.plugins.registry import load_stage, use_plugin_files
from followspot.ports import ports
from followspot.transport.zenoh.network import network_from_data
from followspot.wire import unpack
from followspot_record.order import Order, order_from_line
from followspot_record.record import target_of
from followspot_recording.record_sender import framed_records
from followspot_recording.sink import RecordingSink

if TYPE_CHECKING:
    from followspot_record.far import FarTaps, Take

_PERIOD = 0.5
"""Seconds between two lines."""
_PATIENCE = 3.0
"""Seconds that those who send may take to leave when the run is over."""
_BACKLOG = 256
_BROKEN = (FollowspotError, InvalidMessage, ValueError, KeyError)
"""What a message that cannot be, or a disk that takes no more, raises."""


class RecorderProcess:
    """An open recording, and those who send to it, each heard by a thread."""

    def __init__(self, order: Order) -> None:
        """Raises FollowspotError, OSError."""
        self.messages = self.lost = 0
        self.error = ""
        self.path = order.path
        self._kinds = _kinds(order)
        self._sinks = _sinks(order)
        self._one = threading.Lock()
        self._expected: dict[str, int] = {}
        self._began = time.monotonic()
        self._senders: list[tuple[threading.Thread, socket.socket]] = []
        self._door = socket.socket(socket.AF_UNIX)
        self._door.bind(str(order.listen))
        self._door.listen(_BACKLOG)
        threading.Thread(target=self._admit, daemon=True).start()
        self._far = _far(order, self._hear_far)

    def told(self, state: str) -> dict[str, Any]:
        """What has been recorded so far; seconds since the beginning, bytes of the file."""
        size = self.path.stat().st_size if self.path.exists() else 0
        seconds = round(time.monotonic() - self._began, 1)
        figures = {"bytes": size, "messages": self.messages, "lost": self.lost, "seconds": seconds}
        return {"state": state, "file": str(self.path), **figures, "error": self.error}

    def close(self, *, at_once: bool) -> None:
        """Complete the file; unless at once, after those who send have left."""
        self._door.close()
        if self._far is not None:
            self._far.close()
        deadline = time.monotonic() + (0.0 if at_once else _PATIENCE)
        for thread, _ in self._senders:
            thread.join(max(0.0, deadline - time.monotonic()))
        with self._one:
            for _, sender in self._senders:
                with suppress(OSError):
                    sender.shutdown(socket.SHUT_RDWR)
            for sink in self._sinks.values():
                try:
                    sink.close()
                except FollowspotError as error:
                    self.error = self.error or str(error)
            self._sinks = {}

    def _admit(self) -> None:
        while True:
            try:
                sender, _ = self._door.accept()
            except OSError:
                return
            thread = threading.Thread(target=self._hear, args=(sender,), daemon=True)
            self._senders.append((thread, sender))
            thread.start()

    def _hear(self, sender: socket.socket) -> None:
        """Write what one worker sends, until it leaves or the disk takes no more."""
        expected: dict[str, int] = {}
        with sender:
            try:
                for port, number, packed in framed_records(sender):
                    self._write(port, number, packed, expected)
            except _BROKEN as error:
                self.error = self.error or str(error)

    def _hear_far(self, port: str, number: int, packed: bytes) -> None:
        """Write what a worker on another host sent; where that was started again, its numbers begin anew."""
        if number < self._expected.get(port, 0):
            del self._expected[port]
        try:
            self._write(port, number, packed, self._expected)
        except _BROKEN as error:
            self.error = self.error or str(error)

    def _write(self, port: str, number: int, packed: bytes, expected: dict[str, int]) -> None:
        """Raises one of _BROKEN. expected: the next number of each port; what lies between was lost."""
        message = unpack(packed, self._kinds[port])
        with self._one:
            if port not in self._sinks:
                return
            self.lost += number - expected.get(port, number)
            expected[port] = number + 1
            if isinstance(message, Message):
                self._sinks[port].process(message)
                self.messages += 1


def _far(order: Order, take: Take) -> FarTaps | None:
    """The way from the other hosts, where ports of theirs are recorded. Raises FollowspotError."""
    if order.network is None or not order.far:
        return None
    from followspot_record.far import FarTaps

    return FarTaps(network_from_data(order.network), dict(order.far), take)


def _kinds(order: Order) -> Mapping[str, type[Message]]:
    """The message type of each port."""
    use_plugin_files(order.plan.plugin_files)
    found = {}
    for stage in order.plan.stages:
        for port in ports(load_stage(stage.uses)).outputs:
            found[f"{stage.name}.{port.name}"] = port.type
    return {name: found[name] for name in order.ports}


def _sinks(order: Order) -> dict[str, RecordingSink]:
    """A recording sink for each port, all into one file. Raises FollowspotError."""
    context = Context(room=order.plan.room, out=order.path.parent)
    target = target_of(order.plan, order.ports, Path(order.path.name))
    sinks = {}
    for number, port in enumerate(order.ports):
        sinks[port] = RecordingSink(context, **target.sink_params(port, first=number == 0))
        sinks[port].setup()
    return sinks


def main() -> int:
    """Entry of the process."""
    try:
        taker = RecorderProcess(order_from_line(sys.stdin.readline()))
    except (FollowspotError, OSError) as error:
        _tell({"state": "failed", "error": str(error)})
        return 1
    heard: list[str] = []
    over = threading.Event()

    def listen() -> None:
        heard.append(sys.stdin.readline())
        over.set()

    threading.Thread(target=listen, daemon=True).start()
    _tell(taker.told("on"))
    while not (over.wait(_PERIOD) or taker.error):
        _tell(taker.told("on"))
    taker.close(at_once=bool(taker.error or "".join(heard).strip()))
    _tell(taker.told("failed" if taker.error else "over"))
    return 1 if taker.error else 0


def _tell(about: dict[str, Any]) -> None:
    with suppress(BrokenPipeError):  # the page is gone; the file is completed all the same
        print(json.dumps(about), flush=True)


if __name__ == "__main__":
    sys.exit(main())

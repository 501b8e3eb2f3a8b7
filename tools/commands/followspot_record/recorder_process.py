"""The recorder of a live graph in its own process: `python -m followspot_record.recorder_process`.

The first line of standard input is an `Order`. "stop" ends the recording at once; the end of the input
ends it once all senders have left. Twice a second it prints a line of JSON with its state.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from followspot import Context, Message
from followspot.errors import FollowspotError
from followspot.graph.output_ports import output_ports
from followspot.messages import InvalidMessage
from followspot.plugins.registry import use_plugin_files
from followspot.ports.firing import Firing, is_firings
from followspot.taps.framing import Record
from followspot.taps.receivers import Consume, Gaps, LocalReceiver, RemoteReceiver
from followspot.wire import unpack
from followspot_record.firings import facts_of_middle
from followspot_record.order import Order
from followspot_record.record import target_of
from followspot_recording.sink import RecordingSink

_PERIOD = 0.5
"""Seconds between two lines."""
_TIMEOUT = 3.0
"""Seconds for the senders to leave after the run has ended."""
_BROKEN = (FollowspotError, InvalidMessage, ValueError, KeyError)
"""Errors of malformed messages and full disks."""


class RecorderProcess:
    """An open recording and its senders, each read by a thread."""

    def __init__(self, order: Order) -> None:
        """Raises FollowspotError, OSError."""
        self.messages = self.lost = 0
        self.error = ""
        self.path = order.path
        self._kinds = _kinds(order)
        self._sinks = _sinks(order)
        self._one = threading.Lock()
        self._began = time.monotonic()
        self._local = LocalReceiver(order.listen, self._consume)
        self._remote = _remote(order, self._consume)

    def status(self, state: str) -> dict[str, Any]:
        """The present state; seconds since the beginning, bytes of the file."""
        size = self.path.stat().st_size if self.path.exists() else 0
        seconds = round(time.monotonic() - self._began, 1)
        figures = {"bytes": size, "messages": self.messages, "lost": self.lost, "seconds": seconds}
        return {"state": state, "file": str(self.path), **figures, "error": self.error}

    def close(self, *, at_once: bool) -> None:
        """Complete the file: at once, or after all senders have left."""
        if self._remote is not None:
            self._remote.close()
        self._local.close(0.0 if at_once else _TIMEOUT)
        with self._one:
            for sink in self._sinks.values():
                try:
                    sink.close()
                except FollowspotError as error:
                    self.error = self.error or str(error)
            self._sinks = {}

    def _consume(self, records: Iterator[Record]) -> None:
        """Write what one sender brings, until it leaves or the disk takes no more."""
        gaps = Gaps()
        try:
            for port, number, packed in records:
                self._write(port, packed, gaps.before(port, number))
        except _BROKEN as error:
            self.error = self.error or str(error)

    def _write(self, port: str, packed: bytes, missing: int) -> None:
        """Raises one of _BROKEN. missing: messages that did not come, between the last one and this."""
        message = unpack(packed, self._kinds[port])
        with self._one:
            if port not in self._sinks:
                return
            self.lost += missing
            if isinstance(message, Message):
                self._sinks[port].process(message)
                self.messages += not is_firings(port)


def _remote(order: Order, consume: Consume) -> RemoteReceiver | None:
    """Receives from other hosts if ports there are recorded. Raises FollowspotError."""
    if order.network is None or not order.remote:
        return None
    return RemoteReceiver(order.network, order.remote, consume)


def _kinds(order: Order) -> Mapping[str, type[Message]]:
    """The message type of each port."""
    use_plugin_files(order.plan.plugin_files)
    found = output_ports(order.plan)
    return {name: Firing if is_firings(name) else found[name] for name in order.ports}


def _sinks(order: Order) -> dict[str, RecordingSink]:
    """A recording sink for each port, all into one file. Raises FollowspotError."""
    context = Context(room=order.plan.room, out=order.path.parent)
    names = [name for name in order.ports if not is_firings(name)]
    target = target_of(order.plan, names, Path(order.path.name))
    target = replace(target, metadata={**target.metadata, **facts_of_middle(order.plan)})
    sinks = {}
    for number, port in enumerate(order.ports):
        sinks[port] = RecordingSink(context, **target.sink_params(port, first=number == 0))
        sinks[port].setup()
    return sinks


def main() -> int:
    """Entry of the process."""
    try:
        recorder = RecorderProcess(Order.model_validate_json(sys.stdin.readline()))
    except (FollowspotError, OSError) as error:
        _print_state({"state": "failed", "error": str(error)})
        return 1
    heard: list[str] = []
    over = threading.Event()

    def listen() -> None:
        heard.append(sys.stdin.readline())
        over.set()

    threading.Thread(target=listen, daemon=True).start()
    _print_state(recorder.status("on"))
    while not (over.wait(_PERIOD) or recorder.error):
        _print_state(recorder.status("on"))
    recorder.close(at_once=bool(recorder.error or "".join(heard).strip()))
    _print_state(recorder.status("failed" if recorder.error else "over"))
    return 1 if recorder.error else 0


def _print_state(about: dict[str, Any]) -> None:
    with suppress(BrokenPipeError):  # the page is gone; the file is completed all the same
        print(json.dumps(about), flush=True)


if __name__ == "__main__":
    sys.exit(main())

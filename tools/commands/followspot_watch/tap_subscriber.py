"""Receive messages of taps on ports of a run."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from queue import Empty, Full, Queue
from typing import Any

from followspot.closing import Closing
from followspot.errors import FollowspotError, did_you_mean
from followspot.graph.output_ports import output_ports, port_names, ports_named
from followspot.library.handle import RunHandle
from followspot.library.run_taps import RunTaps
from followspot.messages import InvalidMessage, Message
from followspot.taps.framing import Record
from followspot.wire import unpack

_WAITING = 4096
"""Messages that are kept until they are read; further ones are dropped."""
_LEAVING = 3.0
"""Seconds for the last messages of a run to arrive."""

Received = tuple[str, Message]
"""A port, and a message of its tap."""


def tapped_ports(word: str | None, run: RunHandle) -> dict[str, type[Message]]:
    """The ports that a word names, with the types of their messages; None names all. Raises FollowspotError.

    `color`, `color/cam0` and `color.out` name color/cam0.out, too, and `hall.tracks` what the sub-graph hall
    offers by this name. Only programs on the operator's own host
    receive from ports on that host.
    """
    plan, near = run.plan(), run.metadata().out is not None
    known = output_ports(plan)
    found = [*known] if word is None else ports_named(word, [*known], plan.offered)
    if not found:
        names = {*plan.offered, *(text for name in known for text in port_names(name, plan.offered))}
        raise FollowspotError(f'there is no port "{word}"; {did_you_mean(str(word), names, "ports")}')
    reachable = {n: known[n] for n in found if near or plan.host_of_stage(n.rpartition(".")[0])}
    if not reachable:
        raise FollowspotError(f"{word or plan.graph} runs on the operator's host; run this command there")
    return reachable


class TapSubscriber(Closing):
    """Receives the messages of taps until the run ends."""

    def __init__(self, run: RunHandle, types: Mapping[str, type[Message]], uses: str, **params: Any) -> None:
        """Tap each port. Raises FollowspotError.

        types: of the messages of the tap, by port; uses, params: see `RunTaps`.
        """
        self._types = types
        self._over = run.over
        self._messages: Queue[Received] = Queue(_WAITING)
        self._taps = RunTaps(run, types, uses, self._consume, **params)

    def messages(self, period: float) -> Iterator[Received | None]:
        """All messages, and None once in a period, s."""
        next_at = time.monotonic() + period
        while True:
            with suppress(Empty):
                yield self._messages.get(timeout=max(0.0, next_at - time.monotonic()))
            if time.monotonic() >= next_at:
                next_at = time.monotonic() + period
                if self._over():
                    break
                with suppress(FollowspotError):
                    self._taps.follow()
                yield None
        self._taps.close(_LEAVING)
        while not self._messages.empty():
            yield self._messages.get()

    def close(self) -> None:
        """Remove the taps."""
        self._taps.close()

    def _consume(self, records: Iterator[Record]) -> None:
        """Take the messages of one sender, in a thread."""
        with suppress(ValueError, KeyError):  # a malformed stream
            for port, _, packed in records:
                with suppress(InvalidMessage, Full):
                    message = unpack(packed, self._types[port])
                    if isinstance(message, Message):
                        self._messages.put_nowait((port, message))

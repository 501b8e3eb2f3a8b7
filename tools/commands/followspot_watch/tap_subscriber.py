"""Receive messages of taps on ports of a run: over a socket from this host, over Zenoh from other hosts."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Full, Queue
from tempfile import TemporaryDirectory
from typing import Any

from followspot.errors import FollowspotError, did_you_mean
from followspot.graph.output_ports import output_ports, port_names
from followspot.library.handle import RunHandle, Tapping
from followspot.messages import InvalidMessage, Message
from followspot.taps.framing import Record
from followspot.taps.receivers import LocalReceiver, RemoteReceiver
from followspot.taps.remote import tap_key
from followspot.wire import unpack

_WAITING = 4096
"""Messages that are kept until they are read; further ones are dropped."""
_LEAVING = 3.0
"""Seconds for the last messages of a run to arrive."""

Received = tuple[str, Message]
"""A port, and a message of its tap."""


@dataclass(frozen=True)
class TappedPort:
    """A port with a tap. name: STAGE.PORT; type: of the messages of the tap; host: of the stage."""

    name: str
    type: type[Message]
    host: str


def tapped_ports(word: str | None, run: RunHandle) -> list[TappedPort]:
    """The ports that a word names; None names all. Raises FollowspotError if there is none.

    `color`, `color/cam0` and `color.out` name color/cam0.out, too. Only programs on the operator's own host
    receive from ports on that host.
    """
    plan, near = run.plan(), run.surroundings().out is not None
    known = [
        TappedPort(name, kind, plan.host_of_stage(name.rpartition(".")[0]))
        for name, kind in output_ports(plan).items()
    ]
    found = [port for port in known if word is None or word in port_names(port.name)]
    if not found:
        remedy = did_you_mean(str(word), {name for port in known for name in port_names(port.name)}, "ports")
        raise FollowspotError(f'there is no port "{word}"; {remedy}')
    reachable = [port for port in found if port.host or near]
    if not reachable:
        raise FollowspotError(f"{word or plan.graph} runs on the operator's host; run this command there")
    return reachable


class TapSubscriber:
    """Receives the messages of taps until the run ends.

    over: tells whether the run has ended, and is asked once in a period.
    """

    def __init__(self, path: Path, ports: Sequence[TappedPort], over: Callable[[], bool]) -> None:
        """path: of the socket for taps on this host, created here."""
        self._types = {port.name: port.type for port in ports}
        self._over = over
        self._messages: Queue[Received] = Queue(_WAITING)
        self._local = LocalReceiver(path, self.hear)

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
                yield None
        self.close(_LEAVING)
        while not self._messages.empty():
            yield self._messages.get()

    def hear(self, records: Iterator[Record]) -> None:
        """Take the messages of one sender, in a thread."""
        with suppress(ValueError, KeyError):  # a malformed stream
            for port, _, packed in records:
                with suppress(InvalidMessage, Full):
                    message = unpack(packed, self._types[port])
                    if isinstance(message, Message):
                        self._messages.put_nowait((port, message))

    def close(self, timeout: float = 0.0) -> None:
        """End all connections, with those of this host after this time at the latest, s."""
        self._local.close(timeout)


@contextmanager
def subscribed(
    run: RunHandle, ports: Sequence[TappedPort], uses: str, **params: Any
) -> Iterator[TapSubscriber]:
    """Tap each port, and receive the messages. Raises FollowspotError.

    uses: the tap at each port, with the parameters `socket` and `port`; params: its other parameters.
    """
    with ExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory(prefix="followspot-taps-"))
        path = Path(folder) / "taps"
        subscriber = TapSubscriber(path, ports, run.over)
        stack.callback(subscriber.close)
        keys = {port.name: tap_key(run.run, port.host, port.name, uses) for port in ports if port.host}
        if keys:
            network = run.surroundings().network
            assert network is not None  # it led to the ports on other hosts
            stack.callback(RemoteReceiver(network, keys, subscriber.hear).close)
        places = {port.name: {} if port.host else {"socket": str(path)} for port in ports}
        taps = [Tapping(n, uses, {**params, **place, "port": n}) for n, place in places.items()]
        run.tap(taps)
        stack.callback(run.untap, taps)
        yield subscriber

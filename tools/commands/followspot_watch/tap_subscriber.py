"""Receive messages of taps on ports of a run: over a socket from this host, over Zenoh from other hosts."""

from __future__ import annotations

import os
import selectors
import socket
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from followspot.errors import FollowspotError, did_you_mean
from followspot.graph.output_ports import output_ports, port_names
from followspot.library.handle import RunHandle, Tapping
from followspot.messages import InvalidMessage, Message
from followspot.taps.remote import RemoteTaps
from followspot.wire import unpack
from followspot_dashboard.gate import make_gate
from followspot_dashboard.line import SOCKET, read

_BUFFER = 1 << 18
_WAITING = 4096
"""Packets from other hosts that are kept until they are read; older ones are dropped."""

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

    listener: accepts the connections of taps on this host; over: tells whether the run has ended, and is
    asked while no tap of this host is connected.
    """

    def __init__(
        self, ports: Sequence[TappedPort], listener: socket.socket, over: Callable[[], bool]
    ) -> None:
        self._types = {port.name: port.type for port in ports}
        self._connections = 0
        self._packets: deque[tuple[str, bytes]] = deque(maxlen=_WAITING)
        self._wakeup = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._listener = listener
        self._over = over
        self._selector = selectors.DefaultSelector()
        self._selector.register(listener, selectors.EVENT_READ)
        self._selector.register(self._wakeup, selectors.EVENT_READ)

    def messages(self, period: float) -> Iterator[Received | None]:
        """All messages, and None once in a period, s."""
        next_at = time.monotonic() + period
        while True:
            for key, _ in self._selector.select(max(0.0, next_at - time.monotonic())):
                yield from self._receive(key.fileobj)
            if time.monotonic() >= next_at:
                next_at = time.monotonic() + period
                if not self._connections and self._over():
                    return
                yield None

    def receiver(self, port: str) -> Callable[[bytes], None]:
        """A function that a thread of Zenoh calls with the packets of a port."""

        def receive(packet: bytes) -> None:
            self._packets.append((port, packet))
            os.eventfd_write(self._wakeup, 1)

        return receive

    def close(self) -> None:
        """End all connections."""
        for key in list(self._selector.get_map().values()):
            if isinstance(key.fileobj, socket.socket) and key.fileobj is not self._listener:
                key.fileobj.close()
        self._selector.close()
        os.close(self._wakeup)

    def _receive(self, end: Any) -> Iterator[Received]:
        if end is self._listener:
            self._connections += 1
            self._selector.register(self._listener.accept()[0], selectors.EVENT_READ)
        elif end == self._wakeup:
            yield from self._remote()
        else:
            yield from self._local(end)

    def _local(self, connection: socket.socket) -> Iterator[Received]:
        packet = connection.recv(_BUFFER)
        if packet:
            yield from self._unpacked(packet)
            return
        self._selector.unregister(connection)
        connection.close()
        self._connections -= 1

    def _remote(self) -> Iterator[Received]:
        os.eventfd_read(self._wakeup)
        while self._packets:
            sender, packet = self._packets.popleft()
            if packet.startswith(sender.encode() + b"\0"):  # a host may send for its own ports only
                yield from self._unpacked(packet)

    def _unpacked(self, packet: bytes) -> Iterator[Received]:
        try:
            port, _, packed = read(packet)
            message = unpack(packed, self._types[port])
        except (InvalidMessage, ValueError, KeyError):
            return
        if isinstance(message, Message):
            yield port, message


@contextmanager
def subscribed(
    run: RunHandle, ports: Sequence[TappedPort], uses: str, **params: Any
) -> Iterator[TapSubscriber]:
    """Tap each port, and receive the messages. Raises FollowspotError.

    uses: the sink at each port, with the parameters `folder` and `port`; params: its other parameters.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="followspot-taps-")))
        listener = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
        make_gate(folder).watched = True
        listener.bind(str(folder / SOCKET))
        listener.listen(len(ports))
        subscriber = TapSubscriber(ports, listener, run.over)
        stack.callback(subscriber.close)
        remote = {port.name: port.host for port in ports if port.host}
        if remote:
            _subscribe_remote(stack, subscriber, run, remote, uses)
        places = {port.name: {} if port.host else {"folder": str(folder)} for port in ports}
        taps = [Tapping(n, uses, {**params, **place, "port": n}) for n, place in places.items()]
        run.tap(taps)
        stack.callback(run.untap, taps)
        yield subscriber


def _subscribe_remote(
    stack: ExitStack, subscriber: TapSubscriber, run: RunHandle, hosts: Mapping[str, str], uses: str
) -> None:
    """Subscribe to taps on other hosts. hosts: host of each port."""
    network = run.surroundings().network
    assert network is not None  # it led to the ports on other hosts
    taps = RemoteTaps(network, run.run)
    stack.callback(taps.close)
    for port, host in hosts.items():
        taps.subscribe(port, host, uses, subscriber.receiver(port))

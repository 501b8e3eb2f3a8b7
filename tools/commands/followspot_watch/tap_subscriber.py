"""Hearing what sinks tell of ports of a run: over a socket from this host, over Zenoh from others."""

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
"""Packets from other hosts that may wait to be heard; what comes then is left out."""

Heard = tuple[str, Message]
"""A port, and what was told of it."""


@dataclass(frozen=True)
class HeardPort:
    """A port that is listened to. name: STAGE.PORT; type: of what is told of it; host: of its stage."""

    name: str
    type: type[Message]
    host: str


def chosen(word: str | None, run: RunHandle) -> list[HeardPort]:
    """The ports that a word names, all where it is None. Raises FollowspotError where there is none.

    color/cam0.out is called color, color/cam0 and color.out, too. Ports on the operator's own host can be
    heard there only.
    """
    plan, near = run.plan(), run.surroundings().out is not None
    known = [
        HeardPort(name, kind, plan.host_of_stage(name.rpartition(".")[0]))
        for name, kind in output_ports(plan).items()
    ]
    found = [port for port in known if word is None or word in port_names(port.name)]
    if not found:
        remedy = did_you_mean(str(word), {name for port in known for name in port_names(port.name)}, "ports")
        raise FollowspotError(f'there is no port "{word}"; {remedy}')
    heard = [port for port in found if port.host or near]
    if not heard:
        raise FollowspotError(f"{word or plan.graph} runs on the operator's host; listen there")
    return heard


class TapSubscriber:
    """Hears what is told of ports until the run is over.

    door: where lines of this host knock; over: whether the run is, asked when nothing comes from this host.
    """

    def __init__(self, heard: Sequence[HeardPort], door: socket.socket, over: Callable[[], bool]) -> None:
        self._types = {port.name: port.type for port in heard}
        self._lines = 0
        self._far: deque[tuple[str, bytes]] = deque(maxlen=_WAITING)
        self._wakeup = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._door = door
        self._over = over
        self._selector = selectors.DefaultSelector()
        self._selector.register(door, selectors.EVENT_READ)
        self._selector.register(self._wakeup, selectors.EVENT_READ)

    def heard(self, period: float) -> Iterator[Heard | None]:
        """All that is told, and None once in a period, s."""
        next_at = time.monotonic() + period
        while True:
            for key, _ in self._selector.select(max(0.0, next_at - time.monotonic())):
                yield from self._hear(key.fileobj)
            if time.monotonic() >= next_at:
                next_at = time.monotonic() + period
                if not self._lines and self._over():
                    return
                yield None

    def taker(self, port: str) -> Callable[[bytes], None]:
        """What a thread of Zenoh calls with the packets of a port."""

        def take(packet: bytes) -> None:
            self._far.append((port, packet))
            os.eventfd_write(self._wakeup, 1)

        return take

    def close(self) -> None:
        """Hear no more."""
        for key in list(self._selector.get_map().values()):
            if isinstance(key.fileobj, socket.socket) and key.fileobj is not self._door:
                key.fileobj.close()
        self._selector.close()
        os.close(self._wakeup)

    def _hear(self, end: Any) -> Iterator[Heard]:
        if end is self._door:
            self._lines += 1
            self._selector.register(self._door.accept()[0], selectors.EVENT_READ)
        elif end == self._wakeup:
            yield from self._from_afar()
        else:
            yield from self._from_here(end)

    def _from_here(self, line: socket.socket) -> Iterator[Heard]:
        packet = line.recv(_BUFFER)
        if packet:
            yield from self._unpacked(packet)
            return
        self._selector.unregister(line)
        line.close()
        self._lines -= 1

    def _from_afar(self) -> Iterator[Heard]:
        os.eventfd_read(self._wakeup)
        while self._far:
            sender, packet = self._far.popleft()
            if packet.startswith(sender.encode() + b"\0"):  # a host speaks for its own ports only
                yield from self._unpacked(packet)

    def _unpacked(self, packet: bytes) -> Iterator[Heard]:
        try:
            port, _, packed = read(packet)
            message = unpack(packed, self._types[port])
        except (InvalidMessage, ValueError, KeyError):
            return
        if isinstance(message, Message):
            yield port, message


@contextmanager
def listening(
    run: RunHandle, heard: Sequence[HeardPort], uses: str, **params: Any
) -> Iterator[TapSubscriber]:
    """Put a sink at each port and hear what they tell. Raises FollowspotError.

    uses: the sink, which takes the parameters `folder` and `port`; params: others of it.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="followspot-ear-")))
        door = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
        make_gate(folder).watched = True
        door.bind(str(folder / SOCKET))
        door.listen(len(heard))
        ear = TapSubscriber(heard, door, run.over)
        stack.callback(ear.close)
        far = {port.name: port.host for port in heard if port.host}
        if far:
            _listen_afar(stack, ear, run, far, uses)
        places = {port.name: {} if port.host else {"folder": str(folder)} for port in heard}
        run.tap([Tapping(n, uses, {**params, **place, "port": n}) for n, place in places.items()])
        yield ear


def _listen_afar(
    stack: ExitStack, ear: TapSubscriber, run: RunHandle, far: Mapping[str, str], uses: str
) -> None:
    """Subscribe to what sinks tell on other hosts; far: host of each port."""
    network = run.surroundings().network
    assert network is not None  # ports on other hosts were found through it
    remote = RemoteTaps(network, run.run)
    stack.callback(remote.close)
    for port, host in far.items():
        remote.subscribe(port, host, uses, ear.taker(port))

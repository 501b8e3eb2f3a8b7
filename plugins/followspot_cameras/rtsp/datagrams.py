"""RTP and RTCP by UDP, from the ports that a camera agreed upon (RFC 2326, section 12.39)."""

from __future__ import annotations

import re
import selectors
import socket
import struct
import time
from contextlib import suppress

from followspot.frame_times import to_ns
from followspot_cameras.rtsp.connection import ConnectionLost, Packet, RtspConnection
from followspot_cameras.rtsp.jitter_buffer import JitterBuffer
from followspot_cameras.rtsp.transport import PICTURES, REPORTS

ATTEMPTS = 64
"""To find two free ports in a row, the first of them even (RFC 3550, section 11)."""
RECEIVED = 4 << 20
"""Bytes that the system is asked to keep between two reads: a key picture comes all at once."""
TURN = 64
"""Datagrams of a port that are read before the other one has its turn."""
LONGEST = 1 << 16
ANSWER = 0.001
"""Wait for the rest of an answer on the connection, s: none is needed here."""
EMPTY_REPORT = struct.pack(">BBHI", 0x80, 201, 1, 0)
"""A receiver report about no sender: it opens the way through firewalls that let answers pass."""


class Datagrams:
    """Packets of one session by UDP, in the order in which they were sent. wait: of the jitter buffer, s.

    connection: that of RTSP, whose end ends the packets, too. Raises ConnectionLost.
    """

    def __init__(self, connection: RtspConnection, wait: float) -> None:
        self._connection = connection
        self._senders = {connection.peer}
        self._buffer: JitterBuffer[Packet] = JitterBuffer(to_ns(wait))
        self._reports: list[Packet] = []
        self._ports = _two_ports(connection.own_address)
        self._selector = selectors.DefaultSelector()
        self._selector.register(connection, selectors.EVENT_READ)
        for channel, port in zip((PICTURES, REPORTS), self._ports, strict=True):
            self._selector.register(port, selectors.EVENT_READ, channel)

    @property
    def wanted(self) -> str:
        """The transport that the server is asked for."""
        first, second = (port.getsockname()[1] for port in self._ports)
        return f"RTP/AVP;unicast;client_port={first}-{second}"

    @property
    def late(self) -> int:
        """Packets that came twice, or later than the jitter buffer waits."""
        return self._buffer.late

    def agreed(self, transport: str) -> None:
        """Take the transport that the server chose."""
        source = re.search(r"source=([^;\s]+)", transport)
        if source is not None:
            self._senders.add(source[1].strip("[]"))
        ports = re.search(r"server_port=([0-9]{1,5})-([0-9]{1,5})", transport)
        if ports is None:
            return
        for port, there in zip(self._ports, ports.groups(), strict=True):
            with suppress(OSError, OverflowError):  # no such port; the packets may come all the same
                port.sendto(EMPTY_REPORT, (self._connection.peer, int(there)))

    def packet(self, timeout: float) -> Packet | None:
        """The next packet; None if none comes in time, s. Raises ConnectionLost."""
        end = time.monotonic_ns() + round(timeout * 1e9)
        while True:
            now = time.monotonic_ns()
            found = self._reports.pop(0) if self._reports else self._buffer.next(now)
            if found is not None or now > end:
                return found
            until = min(end, self._buffer.due) if self._buffer.holds else end
            for key, _ in self._selector.select(max(0, until - now) / 1e9 + 1e-6):
                if key.data is None:
                    self._connection.packet(ANSWER)
                else:
                    self._read(key.fileobj, key.data)

    def close(self) -> None:
        """Give the ports back."""
        self._selector.close()
        for port in self._ports:
            port.close()

    def _read(self, port: object, channel: int) -> None:
        assert isinstance(port, socket.socket), "ports are registered with their channels"
        for _ in range(TURN):
            try:
                data, (sender, *_) = port.recvfrom(LONGEST)
            except BlockingIOError:
                return
            except OSError as error:
                raise ConnectionLost(f"its packets cannot be received: {error}") from None
            packet = Packet(channel, data, time.time_ns())
            if sender not in self._senders or len(data) < 4:
                continue
            if channel == REPORTS:
                self._reports.append(packet)
            else:
                self._buffer.add(int.from_bytes(data[2:4], "big"), packet, time.monotonic_ns())


def _two_ports(address: str) -> tuple[socket.socket, socket.socket]:
    """Ports at an own address, in a row. Raises ConnectionLost."""
    for _ in range(ATTEMPTS):
        first = _port(address, 0)
        number = first.getsockname()[1]
        if number % 2 == 0:
            try:
                return first, _port(address, number + 1)
            except OSError:
                pass  # another program has it
        first.close()
    raise ConnectionLost("no two free UDP ports in a row")


def _port(address: str, number: int) -> socket.socket:
    port = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_DGRAM)
    try:
        port.setblocking(False)
        port.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVED)
        port.bind((address, number))
    except OSError:
        port.close()
        raise
    return port

"""How the packets of a session come: on the connection of RTSP itself, or by UDP."""

from __future__ import annotations

from typing import Protocol

from followspot_cameras.rtsp.connection import Packet, RtspConnection

PICTURES, REPORTS = 0, 1
"""Channels of RTP and RTCP."""


class Transport(Protocol):
    """The packets of one session. Every method raises ConnectionLost."""

    @property
    def wanted(self) -> str:
        """The transport that the server is asked for."""

    @property
    def late(self) -> int:
        """Packets that came too late to be used."""

    def agreed(self, transport: str) -> None:
        """Take the transport that the server chose."""

    def packet(self, timeout: float) -> Packet | None:
        """The next packet; None if none comes in time, s."""

    def close(self) -> None:
        """Give back what it has."""


class Interleaved:
    """Packets on the connection itself (RFC 2326, section 10.12): TCP brings all of them, in order."""

    wanted = f"RTP/AVP/TCP;unicast;interleaved={PICTURES}-{REPORTS}"
    late = 0

    def __init__(self, connection: RtspConnection) -> None:
        self.packet = connection.packet

    def agreed(self, transport: str) -> None:
        """Nothing is left to choose."""

    def close(self) -> None:
        """Nothing is left to close: the caller that opened the connection closes it."""

"""Sinks that send UDP datagrams; a slow or broken network neither delays nor ends the graph."""

from __future__ import annotations

import socket
from collections.abc import Callable
from ipaddress import IPv4Address
from typing import Any

from followspot import Field, OutputHost, Stage, StageParams
from followspot.errors import InputError, Mistake


class Datagrams:
    """Sends to one address; drops and counts datagrams that the network does not take; warns once."""

    def __init__(self, host: str, port: int, interface: str, warn: Callable[[str], None]) -> None:
        """host: of the receiver, or a multicast group; interface: own address to send to a group from.

        Raises InputError if the host is unknown.
        """
        self.warn = warn
        self.dropped = 0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setblocking(False)
        try:
            self.address = (socket.gethostbyname(host), port)
            if IPv4Address(self.address[0]).is_multicast:
                card = IPv4Address(interface).packed
                self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, card)
        except (OSError, ValueError) as error:
            self.socket.close()
            why = error.strerror if isinstance(error, OSError) else error
            text = f"cannot send to {host} from {interface}: {why}"
            remedy = "host: a name or an address; interface: this host's own address in that network"
            raise InputError([Mistake(None, text, remedy)]) from None

    def send(self, packet: bytes) -> None:
        """Send one datagram, or drop it."""
        try:
            self.socket.sendto(packet, self.address)
        except ConnectionRefusedError:
            return  # no receiver listened to an earlier datagram; one may start later
        except OSError as error:
            self.dropped += 1
            if self.dropped == 1:
                host, port = self.address
                self.warn(f"the network did not take a packet for {host}:{port}: {error.strerror}")

    def close(self) -> None:
        """Close the socket, and warn of dropped packets."""
        self.socket.close()
        if self.dropped > 1:
            self.warn(f"{self.dropped} packets for {self.address[0]}:{self.address[1]} were not sent")


class DatagramSink(Stage):
    """Base of the sinks that send datagrams."""

    class Params(StageParams):
        """The receiver."""

        host: OutputHost = Field("127.0.0.1", description="receiver: name, address or multicast group")
        port: int = Field(9000, ge=1, le=65535, unit="1", description="UDP port of the receiver")
        interface: str = Field("127.0.0.1", description="own address to send a multicast group from")

    params: Any
    network: Datagrams | None = None

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        p = self.params
        self.network = Datagrams(p.host, p.port, p.interface, self.context.warn)

    def close(self) -> None:
        """Close the socket."""
        if self.network is not None:
            self.network.close()

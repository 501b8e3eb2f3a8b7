"""A socket to send datagrams from, that never makes the graph wait and never ends it."""

from __future__ import annotations

import socket
from collections.abc import Callable
from ipaddress import IPv4Address

from followspot.errors import InputError, Mistake


class Datagrams:
    """Sends to one address; what the network does not take at once is dropped, counted and told once."""

    def __init__(self, host: str, port: int, interface: str, warn: Callable[[str], None]) -> None:
        """host: name or address of the receiver, or a multicast group, which is sent into `interface` only.

        Raises InputError where the host is unknown.
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
            text = f"cannot send to {host} from {interface}: {error}"
            remedy = "host: a name or an address; interface: this computer's own address in that network"
            raise InputError([Mistake(None, text, remedy)]) from None

    def send(self, packet: bytes) -> None:
        """Send one datagram, or drop it."""
        try:
            self.socket.sendto(packet, self.address)
        except ConnectionRefusedError:
            return  # an earlier one found nobody listening; the receiver may come later
        except OSError as error:
            self.dropped += 1
            if self.dropped == 1:
                host, port = self.address
                self.warn(f"the network did not take a packet for {host}:{port}: {error.strerror}")

    def close(self) -> None:
        """Close the socket; tells how many packets were dropped."""
        self.socket.close()
        if self.dropped > 1:
            self.warn(f"{self.dropped} packets for {self.address[0]}:{self.address[1]} were not sent")

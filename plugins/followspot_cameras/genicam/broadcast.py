"""The address that reaches all cameras of one network: 255.255.255.255 goes where the default route leads."""

from __future__ import annotations

import socket
import struct
import sys
from ipaddress import IPv4Network

EVERYWHERE = "255.255.255.255"
SIOCGIFADDR, SIOCGIFNETMASK = 0x8915, 0x891B
"""Questions to Linux about a network interface (netdevice(7)): its address, the mask of its network."""


def broadcast_address(interface: str) -> str:
    """Of the network that an own address is in; that address on loopback, `EVERYWHERE` if it is not known."""
    if interface.startswith("127."):
        return interface
    if not interface or sys.platform != "linux":
        return EVERYWHERE
    for _, name in socket.if_nameindex():
        if _asked(name, SIOCGIFADDR) == interface:
            network = IPv4Network((interface, _asked(name, SIOCGIFNETMASK)), strict=False)
            return str(network.broadcast_address)
    return EVERYWHERE


def _asked(name: str, question: int) -> str:
    """The answer about an interface; "" if there is none."""
    import fcntl  # of Unix alone

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        try:
            answer = fcntl.ioctl(any_socket, question, struct.pack("16s24x", name.encode()))
        except OSError:  # it has no address
            return ""
    return socket.inet_ntoa(answer[20:24])

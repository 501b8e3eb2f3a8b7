"""The address of the page."""

from __future__ import annotations

import ipaddress

from followspot.errors import InputError

HOST, PORT = "127.0.0.1", 8777
"""Default host and port."""


def read_address(option: str, text: str) -> tuple[str, int]:
    """Host and port of an option. Raises InputError."""
    host, colon, port = text.rpartition(":")
    host = host.strip("[]")
    if not (colon and host and port.isdecimal() and len(port) < 6 and int(port) < 1 << 16):
        remedy = f"for example {HOST}:{PORT}, or 0.0.0.0:{PORT}"
        raise InputError.of(f"{option}: {text!r} is no HOST:PORT", remedy)
    return host, int(port)


def is_address(name: str) -> bool:
    """True if a name is an address."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def is_loopback(host: str) -> bool:
    """True if only this host reaches a host."""
    return host == "localhost" or (is_address(host) and ipaddress.ip_address(host).is_loopback)

"""Which texts may name stages, cameras, graphs, rooms and hosts."""

from __future__ import annotations

import re

HOST_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
"""Pattern of host names: one chunk of a Zenoh key."""
MAX_NAME = 100
"""Longest name of anything but a host, characters."""


def is_name(text: str) -> bool:
    """True if a text may name a stage, a camera or a target: letters, digits, _ and -."""
    return 0 < len(text) <= MAX_NAME and all(c.isalnum() or c in "_-" for c in text)


def is_title(text: str) -> bool:
    """True if a text may name a graph or a room: characters that file names may contain."""
    return 0 < len(text) <= MAX_NAME and text.isprintable() and "/" not in text

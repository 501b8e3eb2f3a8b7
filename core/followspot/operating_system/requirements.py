"""Requirements of runs on the operating system; a run on another system is refused with the reason."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path

from followspot.errors import FollowspotError


def check_system() -> None:
    """Raises FollowspotError if a run cannot start: on other systems than Linux."""
    needed = {
        "memfd_create, for memory that workers share": hasattr(os, "memfd_create"),
        "eventfd, which wakes a worker": hasattr(os, "eventfd"),
        "abstract Unix sockets, by which commands find a run": Path("/proc/net/unix").exists(),
        "fcntl and pwd, for seals of memory and owners of runs": all(map(is_importable, ("fcntl", "pwd"))),
    }
    if missing := [what for what, there in needed.items() if not there]:
        listed = "".join(f"\n    {what}" for what in missing)
        remedy = "check, graph and plugins need none of it; for a run take Linux, in a virtual machine, too"
        raise FollowspotError(f"runs need Linux; this system has no{listed}\n  {remedy}")


def is_importable(name: str) -> bool:
    """Whether a module is installed here; it is not imported."""
    try:
        return find_spec(name) is not None
    except ValueError:  # it is known to be missing
        return False

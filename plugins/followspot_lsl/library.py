"""liblsl with a configuration of ours, which it reads once, when it is first used in a process."""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Literal

from followspot import Field, InputAddress, StageParams
from followspot.errors import FollowspotError, InputError

EVERYWHERE = "0.0.0.0"  # noqa: S104  # liblsl knows no other
_loaded = ""
"""The configuration of this process; empty before the library is loaded."""


class LslParams(StageParams):
    """The hosts that can read a stream, and the networks on which streams are sought."""

    host: InputAddress = Field(
        "127.0.0.1",
        description="own address to listen at; liblsl cannot listen on loopback alone, so the stage is "
        "refused unless this is 0.0.0.0, for all networks; then every host that reaches this one may "
        "read the stream",
    )
    scope: Literal["machine", "link", "site"] = Field(
        "machine",
        description="where streams are searched for and announced: this host, its network, or the site; "
        "the same for all stages of a worker",
    )


def load(params: LslParams) -> Any:
    """The module pylsl. Raises InputError unless `host` permits it, FollowspotError if it cannot be had."""
    global _loaded
    if params.host != EVERYWHERE:
        text = f"liblsl listens on all networks of this host, not on {params.host} alone"
        raise InputError.of(
            text, f"set host: {EVERYWHERE} if every host that reaches this one may read the streams"
        )
    wanted = configuration(params.scope)
    if _loaded == wanted:
        return sys.modules["pylsl"]
    if _loaded or "pylsl" in sys.modules:
        text = "liblsl has been loaded with another configuration in this process"
        raise InputError.of(
            text, "give all stages of a worker one scope, or put them into workers of their own"
        )
    try:
        pylsl = _imported(wanted)
    except (ImportError, RuntimeError, OSError) as error:
        remedy = 'pip install "followspot[lsl]"'
        raise FollowspotError(f"this stage needs pylsl: {error}\n    {remedy}") from None
    _loaded = wanted
    return pylsl


def configuration(scope: str) -> str:
    """The text of liblsl's configuration file."""
    text = f"[ports]\nIPv6 = disable\n[multicast]\nResolveScope = {scope}\n"
    if scope == "machine":
        text += "ListenAddress = 127.0.0.1\nMachineAddresses = {127.0.0.1}\n[lab]\nKnownPeers = {127.0.0.1}\n"
    return text + "[log]\nlevel = -1\n"


def _imported(text: str) -> Any:
    """pylsl, after it has read a private file with this text."""
    before = os.environ.get("LSLAPICFG")
    handle, path = tempfile.mkstemp(prefix="followspot-lsl-", suffix=".cfg")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.environ["LSLAPICFG"] = path
        pylsl = importlib.import_module("pylsl")
        pylsl.protocol_version()  # it reads the file now
    finally:
        Path(path).unlink()
        os.environ.pop("LSLAPICFG")
        if before is not None:
            os.environ["LSLAPICFG"] = before
    return pylsl


def wall_clock_offset(pylsl: Any) -> int:
    """The offset of the clock of this host from that of liblsl, ns."""
    now: float = pylsl.local_clock()
    return time.time_ns() - round(now * 1e9)

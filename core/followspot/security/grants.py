"""Grants: the files, network receivers and devices of a host that stages of remote operators may use."""

from __future__ import annotations

import ipaddress
import posixpath
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import SplitResult, urlsplit

from followspot.errors import FollowspotError
from followspot.graph.parameters import path_parameters
from followspot.graph.plan import PlannedStage
from followspot.plugins.registry import load_stage
from followspot.stage_params import DeviceIn, NetworkOut

ANY = "any"
"""Grants every receiver, or every address."""
_CAMERAS = range(100)
"""Numbers of cameras; OpenCV gives greater numbers another meaning."""


@dataclass(frozen=True)
class Grants:
    """The grants of a host; cameras by number, receivers on this host and loopback are always granted.

    media: folder of input files, None for none; send_to: other hosts to which stages may send; opens: device
    paths, stream addresses and own addresses that stages may open, and all below these.
    """

    media: Path | None = None
    send_to: tuple[str, ...] = ()
    opens: tuple[str, ...] = ()

    def check(self, stage: PlannedStage) -> None:
        """Raise FollowspotError if a stage would use a receiver, a device or an address without a grant."""
        for value in _marked_values(stage, NetworkOut):
            host = _host(str(value))
            if host and not (_is_here(host) or ANY in self.send_to or host in map(_host, self.send_to)):
                raise FollowspotError(
                    f"stage {stage.name} would send to {host}; the owner of this host allows that with "
                    f"followspot agent --send-to {host}"
                )
        for value in _marked_values(stage, DeviceIn):
            if not (
                _is_camera(value)
                or _is_here(str(value))
                or ANY in self.opens
                or any(_covers(a, str(value)) for a in self.opens)
            ):
                raise FollowspotError(
                    f"stage {stage.name} would open {value!r}; the owner of this host allows that with "
                    "followspot agent --open ADDRESS"
                )


def _marked_values(stage: PlannedStage, mark: type) -> Iterator[Any]:
    """The values of a stage's parameters that have this mark."""
    for name in path_parameters(load_stage(stage.uses).Params, mark):
        value = stage.params.get(name)
        if value is not None:
            yield value


def _host(receiver: str) -> str:
    """The host of a receiver, which is a host name or a URL."""
    if "://" not in receiver:
        return receiver.strip().lower()
    parts = _split(receiver)
    return receiver if parts is None else (parts.hostname or receiver)


def _is_here(host: str) -> bool:
    """True for a loopback address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _is_camera(device: Any) -> bool:
    return type(device) is int and device in _CAMERAS


def _covers(allowed: str, wanted: str) -> bool:
    """True if a URL, a device path or an own address equals the allowed one or lies below it."""
    if allowed == wanted:
        return True
    if "://" not in allowed:
        return "://" not in wanted and _is_path_below(wanted, allowed)
    ours, theirs = _split(wanted), _split(allowed)
    if ours is None or theirs is None:
        return False
    same = (ours.scheme, ours.hostname) == (theirs.scheme, theirs.hostname)
    port = theirs.port is None or ours.port == theirs.port
    return same and port and _is_path_below(ours.path or "/", theirs.path or "/")


def _is_path_below(wanted: str, allowed: str) -> bool:
    """True if an absolute path equals the allowed one or lies below it; symbolic links are not resolved."""
    if not (wanted.startswith("/") and allowed.startswith("/")) or "\0" in wanted:
        return False
    found, root = posixpath.normpath(wanted), posixpath.normpath(allowed)
    return found == root or found.startswith(root.rstrip("/") + "/")


def _split(address: str) -> SplitResult | None:
    """The parts of a URL; None if it is not a valid one."""
    try:
        parts = urlsplit(address)
        _ = parts.port
    except ValueError:
        return None
    return parts if parts.hostname else None

"""What the owner of a host lets orders from elsewhere use: files, receivers in the network, devices."""

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
from followspot.stage import DeviceIn, NetworkOut

ANY = "any"
"""Stands for every receiver, or every address."""
_CAMERAS = range(100)
"""Numbers of cameras; OpenCV takes greater ones for other ways to open something."""


@dataclass(frozen=True)
class Grants:
    """media: folder with camera files, None for none; send_to: hosts beside this one to which stages may
    send; opens: paths of devices and addresses of streams that they may open, and what lies below these.

    Cameras by number, and receivers on this host, are always granted.
    """

    media: Path | None = None
    send_to: tuple[str, ...] = ()
    opens: tuple[str, ...] = ()

    def check(self, stage: PlannedStage) -> None:
        """Raises FollowspotError where a stage would send to, or open, what is not granted."""
        for value in _given(stage, NetworkOut):
            host = _host(str(value))
            if host and not (_is_here(host) or ANY in self.send_to or host in map(_host, self.send_to)):
                raise FollowspotError(
                    f"stage {stage.name} would send to {host}; the owner of this host allows that with "
                    f"followspot agent --send-to {host}"
                )
        for value in _given(stage, DeviceIn):
            if not (_is_camera(value) or ANY in self.opens or any(_below(str(value), a) for a in self.opens)):
                raise FollowspotError(
                    f"stage {stage.name} would open {value!r}; the owner of this host allows that with "
                    "followspot agent --open ADDRESS"
                )


def _given(stage: PlannedStage, mark: type) -> Iterator[Any]:
    """The values of the parameters of a stage that are marked so."""
    for name in path_parameters(load_stage(stage.uses).Params, mark):
        value = stage.params.get(name)
        if value is not None:
            yield value


def _host(receiver: str) -> str:
    """The host of a receiver, which may be written as an address with scheme and port."""
    if "://" not in receiver:
        return receiver.strip().lower()
    parts = _split(receiver)
    return receiver if parts is None else (parts.hostname or receiver)


def _is_here(host: str) -> bool:
    """Whether what is sent there stays on this host."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _is_camera(device: Any) -> bool:
    return type(device) is int and device in _CAMERAS


def _below(wanted: str, allowed: str) -> bool:
    """Whether an address, or the path of a device, is the allowed one or lies below it."""
    if "://" not in allowed:
        return "://" not in wanted and _is_path_below(wanted, allowed)
    ours, theirs = _split(wanted), _split(allowed)
    if ours is None or theirs is None:
        return False
    same = (ours.scheme, ours.hostname) == (theirs.scheme, theirs.hostname)
    port = theirs.port is None or ours.port == theirs.port
    return same and port and _is_path_below(ours.path or "/", theirs.path or "/")


def _is_path_below(wanted: str, allowed: str) -> bool:
    """Of two absolute paths, by their names alone."""
    if not (wanted.startswith("/") and allowed.startswith("/")) or "\0" in wanted:
        return False
    found, root = posixpath.normpath(wanted), posixpath.normpath(allowed)
    return found == root or found.startswith(root.rstrip("/") + "/")


def _split(address: str) -> SplitResult | None:
    """Its parts; None where it is no address."""
    try:
        parts = urlsplit(address)
        _ = parts.port
    except ValueError:
        return None
    return parts if parts.hostname else None

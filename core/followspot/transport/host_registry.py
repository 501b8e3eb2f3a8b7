"""The folder of a host's certificates, and the registry of hosts: certified names and roles.

``ca.pem``, ``cert.pem``, ``key.pem`` serve TLS. ``hosts.json`` says to which host the folder belongs and
lists all hosts, for Zenoh's access control knows certificates by their common name only. A host that is not
listed may do nothing.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Literal, get_args

from followspot.errors import FollowspotError
from followspot.files import DOCUMENT, read_bytes
from followspot.valid_values.names import HOST_NAME

HostRole = Literal["camera", "worker", "operator", "router"]
"""camera, worker: runs an agent (a worker's stages may see every port); operator: may also start, stop and
change runs; router: passes on what others send."""
ROLES: tuple[HostRole, ...] = get_args(HostRole)
REGISTRY = "hosts.json"
FORMAT = 1
SOON = timedelta(days=30)
"""Remaining validity below which a certificate is reported."""
_FILES = ("ca.pem", "cert.pem", "key.pem", REGISTRY)


@dataclass(frozen=True)
class RegisteredHost:
    """A host in the registry; expires: when its certificate ends."""

    name: str
    role: HostRole
    expires: datetime


@dataclass(frozen=True)
class Certificates:
    """A checked folder of certificates: its own host, and all hosts."""

    folder: Path
    own: RegisteredHost
    members: tuple[RegisteredHost, ...]


def read_certificates(folder: Path, now: datetime | None = None) -> Certificates:
    """Check the folder of a host's certificates.

    Raises FollowspotError if a file is missing, others can read the key, the files do not fit each other,
    or the certificate is not valid now.
    """
    for name in _FILES:
        if not (folder / name).is_file():
            raise FollowspotError(
                f"{folder / name} is missing; make it where the authority is: followspot certs host NAME, "
                "then copy the folder of that host"
            )
    mode = (folder / "key.pem").stat().st_mode & 0o777
    if mode & 0o077:
        raise FollowspotError(
            f"{folder / 'key.pem'} has mode {mode:04o}, others can read it; chmod 600 {folder / 'key.pem'}"
        )
    own, members = read_host_registry(folder / REGISTRY)
    found = next((member for member in members if member.name == own), None)
    if found is None:
        raise FollowspotError(f"{folder / REGISTRY} does not list {own}; copy it again from the authority")
    if found.expires <= (now or datetime.now(UTC)):
        raise FollowspotError(
            f"the certificate of {own} in {folder} expired on {found.expires:%Y-%m-%d}; "
            f"make a new one where the authority is: followspot certs host {own} --renew"
        )
    from followspot.transport.own_certificate import check_own_certificate  # ssl, which few runs need

    check_own_certificate(folder, own)
    return Certificates(folder, found, members)


def expiring_soon(folder: Path, now: datetime | None = None) -> str:
    """That the certificate of a host ends soon, with the remedy; "" if it does not, or has ended.

    folder: of the host's certificates; "" also if its registry cannot be read: `read_certificates` says that.
    """
    try:
        own, members = read_host_registry(folder / REGISTRY)
    except FollowspotError:
        return ""
    now = now or datetime.now(UTC)
    for member in members:
        if member.name == own and now < member.expires < now + SOON:
            return (
                f"the certificate of {own} ends on {member.expires:%Y-%m-%d}, and no other host connects to "
                f"this one then; make a new one where the authority is: followspot certs host {own} --renew"
            )
    return ""


def read_host_registry(path: Path) -> tuple[str, tuple[RegisteredHost, ...]]:
    """Name of the host whose registry it is ("" the authority's), and all hosts. Raises FollowspotError."""
    try:
        data = json.loads(read_bytes(path, DOCUMENT))
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise ValueError(f"it is not of format {FORMAT}")
        return str(data["own"]), tuple(_member(name, entry) for name, entry in data["hosts"].items())
    except (OSError, ValueError, KeyError, AttributeError, TypeError, RecursionError) as error:
        raise FollowspotError(f"{path} is no list of hosts: {error}") from None


def registry_text(own: str, members: Mapping[str, RegisteredHost]) -> str:
    """The file `hosts.json`."""
    hosts = {m.name: {"role": m.role, "expires": m.expires.isoformat()} for m in members.values()}
    return json.dumps({"format": FORMAT, "own": own, "hosts": hosts}, indent=2) + "\n"


def _member(name: str, entry: Any) -> RegisteredHost:
    role, expires = entry["role"], datetime.fromisoformat(entry["expires"])
    if HOST_NAME.fullmatch(name) is None or role not in ROLES:
        raise ValueError(f"{str(name)[:80]!r} with the role {str(role)[:80]!r} cannot be a host")
    if expires.tzinfo is None:
        raise ValueError(f"the time {entry['expires']!r} has no time zone")
    return RegisteredHost(name, role, expires)

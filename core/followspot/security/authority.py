"""A small certificate authority in a folder, with a folder of certificates for each host.

``DIR/authority/`` has the authority's key and certificate and must stay on this machine. The user copies
``DIR/NAME/`` to the host NAME. ``DIR/hosts.json`` is the host registry.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

from followspot.errors import FollowspotError, writing
from followspot.files import DOCUMENT, read_bytes
from followspot.security.certificates import (
    Certificate,
    Issuer,
    PrivateKey,
    authority_certificate,
    certificate_text,
    key_text,
    new_key,
)
from followspot.transport.host_registry import (
    REGISTRY,
    HostRole,
    RegisteredHost,
    read_host_registry,
    registry_text,
)
from followspot.valid_values.names import HOST_NAME

AUTHORITY = "authority"
HOST_DAYS = 825
"""Default validity of a host's certificate, days."""
MAX_HOSTS = 1000


class Authority:
    """The certificate authority in a folder."""

    def __init__(self, folder: Path, now: datetime | None = None) -> None:
        """Read the key and check the certificate.

        now: the time, by default of this machine. Raises FollowspotError if the folder has no authority,
        other users can read its key, or its certificate has expired.
        """
        self.folder = folder
        self.now = now or datetime.now(UTC)
        home = folder / AUTHORITY
        if not (home / "key.pem").is_file() or not (home / "ca.pem").is_file():
            raise FollowspotError(f"there is no authority in {folder}; followspot certs init --dir {folder}")
        mode = (home / "key.pem").stat().st_mode & 0o777
        if mode & 0o077:
            raise FollowspotError(
                f"{home / 'key.pem'} has mode {mode:04o}: every user who can read it can make certificates; "
                f"chmod 600 {home / 'key.pem'}, or make a new authority if others may have read it"
            )
        try:
            key, certificate = (read_bytes(home / name, DOCUMENT) for name in ("key.pem", "ca.pem"))
            issuer = Issuer.read(key, certificate)
        except (OSError, ValueError, TypeError) as error:
            raise FollowspotError(f"the authority in {home} cannot be read: {error}") from None
        if issuer is None:
            raise FollowspotError(f"{home / 'key.pem'} is not the key that certs init made")
        self._issuer = issuer
        if self.expires <= self.now:
            raise FollowspotError(f"the authority in {home} expired on {self.expires:%Y-%m-%d}; replace it")
        _, members = read_host_registry(folder / REGISTRY)
        self._members = {member.name: member for member in members}

    @property
    def expires(self) -> datetime:
        """When the certificates of the authority and of all hosts expire at the latest."""
        return self._issuer.certificate.not_valid_after_utc

    @property
    def members(self) -> tuple[RegisteredHost, ...]:
        """All hosts, sorted by name."""
        return tuple(self._members[name] for name in sorted(self._members))

    def add(
        self,
        name: str,
        role: HostRole,
        addresses: Sequence[str] = (),
        days: int = HOST_DAYS,
        *,
        renew: bool = False,
    ) -> Path:
        """Make the folder of a host, and update the host registry in all folders.

        addresses: IP addresses or DNS names of the host; days: validity of the certificate; renew: replace
        the certificate of a known host. Raises FollowspotError if the name is invalid or taken.
        """
        if HOST_NAME.fullmatch(name) is None or name in (AUTHORITY, REGISTRY):
            raise FollowspotError(f"{name!r} cannot be the name of a host; use letters, digits, - _ .")
        if name in self._members and not renew:
            raise FollowspotError(f"{name} has a certificate already; --renew replaces it")
        if name not in self._members and (self.folder / name).exists():
            raise FollowspotError(f"{self.folder / name} is in the way; move it elsewhere")
        if role != "operator" and name == "operator":
            raise FollowspotError("the name operator is reserved for operators; choose another name")
        if len(self._members) >= MAX_HOSTS:
            raise FollowspotError(f"there are {MAX_HOSTS} hosts, the most that are allowed")
        until = min(self.now + timedelta(days=days), self.expires).replace(microsecond=0)
        member = RegisteredHost(name, role, until)
        key = new_key()
        certificate = self._issuer.host_certificate(member, key, [name, *addresses], self.now)
        with _whole(self.folder / name) if name not in self._members else writing(self.folder / name):
            self._write_host(name, key, certificate)
        self._members[name] = member
        self._write_registries()
        return self.folder / name

    def remove(self, name: str) -> None:
        """Remove a host from all registries: hosts with the new one reject it. Raises FollowspotError."""
        if self._members.pop(name, None) is None:
            raise FollowspotError(
                f"there is no host {name}; known: {', '.join(sorted(self._members)) or 'none'}"
            )
        shutil.rmtree(self.folder / name, ignore_errors=True)
        self._write_registries()

    def _write_host(self, name: str, key: PrivateKey, certificate: Certificate) -> None:
        home = self.folder / name
        home.mkdir(mode=0o700, exist_ok=True)
        _write(home / "key.pem", key_text(key), 0o600)
        _write(home / "cert.pem", certificate_text(certificate), 0o644)
        _write(home / "ca.pem", certificate_text(self._issuer.certificate), 0o644)

    def _write_registries(self) -> None:
        _write(self.folder / REGISTRY, registry_text("", self._members).encode(), 0o644)
        for name in self._members:
            if (self.folder / name).is_dir():
                _write(self.folder / name / REGISTRY, registry_text(name, self._members).encode(), 0o644)


def create_authority(folder: Path, now: datetime | None = None) -> Authority:
    """Make an authority. Raises FollowspotError if the folder has one: a new key voids its certificates."""
    now = now or datetime.now(UTC)
    home = folder / AUTHORITY
    if home.exists() or (folder / REGISTRY).exists():
        raise FollowspotError(
            f"there is an authority in {folder}; choose another --dir, or move it elsewhere"
        )
    key = new_key()
    certificate = authority_certificate(key, now)
    with writing(home):
        home.mkdir(mode=0o700, parents=True)
    with _whole(home):
        _write(home / "key.pem", key_text(key), 0o600)
        _write(home / "ca.pem", certificate_text(certificate), 0o644)
        _write(folder / REGISTRY, registry_text("", {}).encode(), 0o644)
    return Authority(folder, now)


@contextmanager
def _whole(home: Path) -> Iterator[None]:
    """Remove a new folder that could not be filled: half of it would be in the way of the next try.

    Raises FollowspotError.
    """
    try:
        yield
    except OSError as error:
        shutil.rmtree(home, ignore_errors=True)
        raise FollowspotError(f"{home} cannot be written: {error.strerror}") from None


def _write(path: Path, text: bytes, mode: int) -> None:
    """Write a file atomically; it never has wider permissions than `mode`."""
    fresh = path.with_name(f".{path.name}.new")
    fresh.unlink(missing_ok=True)
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(text)
    fresh.replace(path)

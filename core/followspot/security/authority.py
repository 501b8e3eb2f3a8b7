"""A small certificate authority in a folder: ECDSA P-256, one folder of certificates for each host.

``DIR/authority/`` has the authority's key and certificate and must stay on this machine. The user copies
``DIR/NAME/`` to the host NAME. ``DIR/hosts.json`` is the host registry. Only the machine that issues
certificates needs the package cryptography; Zenoh brings its own TLS.
"""

from __future__ import annotations

import ipaddress
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

from followspot.errors import FollowspotError, writing
from followspot.files import DOCUMENT, read_bytes
from followspot.transport.host_registry import (
    NAME,
    REGISTRY,
    HostRole,
    RegisteredHost,
    read_host_registry,
    registry_text,
)

try:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.hashes import SHA256
    from cryptography.hazmat.primitives.serialization import (
        Encoding,
        NoEncryption,
        PrivateFormat,
        load_pem_private_key,
    )
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
except ImportError:
    raise FollowspotError(
        "certificates are made with the package cryptography: pip install 'followspot[certs]'"
    ) from None

AUTHORITY = "authority"
AUTHORITY_YEARS = 10
HOST_DAYS = 825
"""Default validity of a host's certificate, days."""
MAX_HOSTS = 1000
_BACKDATING = timedelta(hours=1)
"""Certificates are valid from this long before their issue, for hosts whose clocks are late."""
_LABEL = r"(?!-)[A-Za-z0-9_-]{1,63}(?<!-)"
_HOST_NAME = re.compile(rf"(?!(?:.*\.)?[0-9]+\Z){_LABEL}(\.{_LABEL})*")
"""The last part of a host name is no number (RFC 1123): "192.168.0.700" is a mistyped address."""


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
            key = load_pem_private_key(read_bytes(home / "key.pem", DOCUMENT), None)
            self._certificate = x509.load_pem_x509_certificate(read_bytes(home / "ca.pem", DOCUMENT))
        except (OSError, ValueError, TypeError) as error:
            raise FollowspotError(f"the authority in {home} cannot be read: {error}") from None
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise FollowspotError(f"{home / 'key.pem'} is not the key that certs init made")
        self._key = key
        if self.expires <= self.now:
            raise FollowspotError(f"the authority in {home} expired on {self.expires:%Y-%m-%d}; replace it")
        _, members = read_host_registry(folder / REGISTRY)
        self._members = {member.name: member for member in members}

    @property
    def expires(self) -> datetime:
        """When the certificates of the authority and of all hosts expire at the latest."""
        return self._certificate.not_valid_after_utc

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
        if NAME.fullmatch(name) is None or name in (AUTHORITY, REGISTRY):
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
        key = ec.generate_private_key(ec.SECP256R1())
        certificate = self._issue(member, key, _alternative_names([name, *addresses]))
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

    def _issue(
        self, member: RegisteredHost, key: ec.EllipticCurvePrivateKey, names: Iterable[x509.GeneralName]
    ) -> x509.Certificate:
        """A host's certificate, signed by the authority."""
        usage = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
        issuer = self._key.public_key()
        return (
            _builder(_subject(member.name, member.role), key, self.now, member.expires)
            .issuer_name(self._certificate.subject)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(x509.ExtendedKeyUsage(usage), critical=False)
            .add_extension(x509.SubjectAlternativeName(names), critical=False)
            .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(issuer), critical=False)
            .sign(self._key, SHA256())
        )

    def _write_host(self, name: str, key: ec.EllipticCurvePrivateKey, certificate: x509.Certificate) -> None:
        home = self.folder / name
        home.mkdir(mode=0o700, exist_ok=True)
        _write(home / "key.pem", _key_text(key), 0o600)
        _write(home / "cert.pem", certificate.public_bytes(Encoding.PEM), 0o644)
        _write(home / "ca.pem", self._certificate.public_bytes(Encoding.PEM), 0o644)

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
    key = ec.generate_private_key(ec.SECP256R1())
    subject = _subject("followspot authority", AUTHORITY)
    signing = x509.KeyUsage(False, False, False, False, False, True, True, False, False)
    certificate = (
        _builder(subject, key, now, now + timedelta(days=round(365.25 * AUTHORITY_YEARS)))
        .issuer_name(subject)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(signing, critical=True)
        .sign(key, SHA256())
    )
    with writing(home):
        home.mkdir(mode=0o700, parents=True)
    with _whole(home):
        _write(home / "key.pem", _key_text(key), 0o600)
        _write(home / "ca.pem", certificate.public_bytes(Encoding.PEM), 0o644)
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


def _builder(
    subject: x509.Name, key: ec.EllipticCurvePrivateKey, now: datetime, until: datetime
) -> x509.CertificateBuilder:
    """The parts of a certificate that hosts and the authority have in common."""
    public = key.public_key()
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .public_key(public)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - _BACKDATING)
        .not_valid_after(until)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(public), critical=False)
    )


def _subject(name: str, unit: str) -> x509.Name:
    attributes = [(NameOID.COMMON_NAME, name), (NameOID.ORGANIZATIONAL_UNIT_NAME, unit)]
    return x509.Name([x509.NameAttribute(kind, text) for kind, text in attributes])


def _alternative_names(addresses: Sequence[str]) -> list[x509.GeneralName]:
    """The addresses and loopback as names in a certificate. Raises FollowspotError for an invalid one."""
    names: list[x509.GeneralName] = []
    for address in dict.fromkeys(["localhost", "127.0.0.1", "::1", *addresses]):
        try:
            names.append(x509.IPAddress(ipaddress.ip_address(address)))
        except ValueError:
            if _HOST_NAME.fullmatch(address) is None:
                raise FollowspotError(f"{address!r} is neither an IP address nor a host name") from None
            names.append(x509.DNSName(address))
    return names


def _key_text(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def _write(path: Path, text: bytes, mode: int) -> None:
    """Write a file atomically; it never has wider permissions than `mode`."""
    fresh = path.with_name(f".{path.name}.new")
    fresh.unlink(missing_ok=True)
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(text)
    fresh.replace(path)

"""Keys and certificates of an authority and its hosts: ECDSA P-256.

Only the machine that issues certificates needs the package cryptography; Zenoh brings its own TLS.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from followspot.errors import FollowspotError
from followspot.transport.host_registry import RegisteredHost

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

Certificate = x509.Certificate
PrivateKey = ec.EllipticCurvePrivateKey

AUTHORITY_YEARS = 10
_BACKDATING = timedelta(hours=1)
"""Certificates are valid from this long before their issue, for hosts whose clocks are late."""
_LABEL = r"(?!-)[A-Za-z0-9_-]{1,63}(?<!-)"
_HOST_NAME = re.compile(rf"(?!(?:.*\.)?[0-9]+\Z){_LABEL}(\.{_LABEL})*")
"""The last part of a host name is no number (RFC 1123): "192.168.0.700" is a mistyped address."""


@dataclass(frozen=True)
class Issuer:
    """The key of an authority, and its certificate."""

    key: PrivateKey
    certificate: Certificate

    @classmethod
    def read(cls, key: bytes, certificate: bytes) -> Issuer | None:
        """From PEM; None if the key is of another kind. Raises ValueError, TypeError."""
        private = load_pem_private_key(key, None)
        found = x509.load_pem_x509_certificate(certificate)
        return cls(private, found) if isinstance(private, PrivateKey) else None

    def host_certificate(
        self, host: RegisteredHost, key: PrivateKey, addresses: Sequence[str], now: datetime
    ) -> Certificate:
        """The certificate of a host. addresses: IP addresses and DNS names of the host; now: its beginning.

        Raises FollowspotError for an invalid address.
        """
        names = _alternative_names(addresses)
        usage = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
        issuer = self.key.public_key()
        return (
            _builder(_subject(host.name, host.role), key, now, host.expires)
            .issuer_name(self.certificate.subject)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(x509.ExtendedKeyUsage(usage), critical=False)
            .add_extension(x509.SubjectAlternativeName(names), critical=False)
            .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(issuer), critical=False)
            .sign(self.key, SHA256())
        )


def new_key() -> PrivateKey:
    """A new private key."""
    return ec.generate_private_key(ec.SECP256R1())


def authority_certificate(key: PrivateKey, now: datetime) -> Certificate:
    """The certificate of a new authority, signed by itself. now: its beginning."""
    subject = _subject("followspot authority", "authority")
    signing = x509.KeyUsage(False, False, False, False, False, True, True, False, False)
    return (
        _builder(subject, key, now, now + timedelta(days=round(365.25 * AUTHORITY_YEARS)))
        .issuer_name(subject)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(signing, critical=True)
        .sign(key, SHA256())
    )


def key_text(key: PrivateKey) -> bytes:
    """The key as PEM."""
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def certificate_text(certificate: Certificate) -> bytes:
    """The certificate as PEM."""
    return certificate.public_bytes(Encoding.PEM)


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

"""The check of a host's own certificate: a TLS handshake with itself, in memory."""

from __future__ import annotations

import ssl
from pathlib import Path
from typing import cast

from followspot.errors import FollowspotError

_FLIGHTS = 3
"""Turns of each side that a handshake takes at most."""
_NOT_YET_VALID, _EXPIRED = 9, 10
"""OpenSSL's numbers of errors that the clock may be at fault for."""


def check_own_certificate(folder: Path, own: str) -> None:
    """Raises FollowspotError unless the folder's files fit each other, now, and are those of the host `own`.

    Zenoh names no file if they do not, and the other hosts refuse this one without a word to it.
    """
    server, client = _server(folder, own), _client(folder, own)
    try:
        name = _name(_verified(server, client))
    except ssl.SSLCertVerificationError as error:
        raise FollowspotError(f"{folder / 'cert.pem'}: {_reason(error, folder, own)}") from None
    if name != own:
        raise FollowspotError(
            f"{folder / 'cert.pem'} is the certificate of {name}, not of {own}\n{_copy_again(own)}"
        )


def _server(folder: Path, own: str) -> ssl.SSLContext:
    """The side that shows the certificate. Raises FollowspotError if the key is another's."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    key, certificate = folder / "key.pem", folder / "cert.pem"
    try:
        context.load_cert_chain(certificate, key, password=str)  # without a password it would ask
    except PermissionError:
        raise FollowspotError(
            f"this user cannot read {key} or {certificate}; chown both to the user that runs followspot"
        ) from None
    except (OSError, ValueError) as error:
        raise FollowspotError(
            f"{key} is not the key of {certificate}: {error.args[-1]}\n{_copy_again(own)}"
        ) from None
    return context


def _client(folder: Path, own: str) -> ssl.SSLContext:
    """The side that asks for a certificate of the authority. Raises FollowspotError."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    try:
        context.load_verify_locations(folder / "ca.pem")
    except (OSError, ValueError) as error:
        raise FollowspotError(
            f"{folder / 'ca.pem'} is no certificate of an authority: {error.args[-1]}\n{_copy_again(own)}"
        ) from None
    return context


def _verified(server: ssl.SSLContext, client: ssl.SSLContext) -> dict[str, object]:
    """What the client reads from the server's certificate. Raises SSLCertVerificationError."""
    down, up = ssl.MemoryBIO(), ssl.MemoryBIO()
    asking, showing = client.wrap_bio(down, up), server.wrap_bio(up, down, server_side=True)
    for _ in range(_FLIGHTS):
        for side in (asking, showing):
            try:
                side.do_handshake()
            except ssl.SSLWantReadError:
                continue
    return cast("dict[str, object]", asking.getpeercert())


def _name(certificate: dict[str, object]) -> str:
    """The common name in a certificate."""
    parts = cast("tuple[tuple[tuple[str, str], ...], ...]", certificate["subject"])
    return next((value for part in parts for key, value in part if key == "commonName"), "")


def _reason(error: ssl.SSLCertVerificationError, folder: Path, own: str) -> str:
    """What is wrong with a certificate, with the remedy."""
    renew = f"make a new one where the authority is: followspot certs host {own} --renew"
    if error.verify_code == _NOT_YET_VALID:
        return f"{error.verify_message}; set the clock of this host, or {renew}"
    if error.verify_code == _EXPIRED:
        return f"{error.verify_message}; {renew}, or set the clock of this host"
    authority = f"it is not of the authority in {folder / 'ca.pem'}"
    return f"{authority} ({error.verify_message})\n{_copy_again(own)}"


def _copy_again(own: str) -> str:
    return f"    copy the whole folder of {own} again from where the authority is"

"""Why an endpoint cannot be reached, found by a connection of its own: Zenoh tries again without a word."""

from __future__ import annotations

import re
import socket
import ssl
from collections.abc import Sequence
from pathlib import Path

_TIMEOUT = 2.0
"""Seconds that the other end has to answer."""
_REFUSAL = 0.5
"""Seconds after a handshake in which the other end refuses the certificate, if it does."""
_ENDPOINT = re.compile(r"(?P<protocol>tcp|tls)/(?P<host>[^?#]+):(?P<port>[0-9]+)(?:[?#].*)?")
_NOT_YET_VALID, _EXPIRED = 9, 10
_OTHER_NAME, _OTHER_ADDRESS = 62, 64
"""OpenSSL's numbers of what is wrong with a certificate."""


def unreached(endpoints: Sequence[str], certificates: str) -> str:
    """Why endpoints cannot be reached, with the remedies; "" if nothing is wrong with any.

    certificates: the folder of this host's certificates, "" for none.
    """
    found = {endpoint: _fault(endpoint, certificates) for endpoint in endpoints}
    return "; ".join(f"{endpoint}: {fault}" for endpoint, fault in found.items() if fault)


def _fault(endpoint: str, certificates: str) -> str:
    """What keeps this host from an endpoint, "" if nothing does, or if it is of another protocol."""
    found = _ENDPOINT.fullmatch(endpoint)
    if found is None:
        return ""
    host = found["host"].strip("[]")
    try:
        with socket.create_connection((host, int(found["port"])), _TIMEOUT) as link:
            return _refusal(link, host, Path(certificates)) if found["protocol"] == "tls" else ""
    except ConnectionRefusedError:
        return "nothing listens there"
    except TimeoutError:
        return "nothing answers: is the host there, and does a firewall let this port through?"
    except OSError as error:
        return error.strerror or str(error)


def _refusal(link: socket.socket, host: str, folder: Path) -> str:
    """Which end refuses the certificate of the other, and why; "" if none does."""
    context = ssl.create_default_context(cafile=folder / "ca.pem")
    context.load_cert_chain(folder / "cert.pem", folder / "key.pem", password=str)
    try:
        with context.wrap_socket(link, server_hostname=host) as secured:
            secured.settimeout(_REFUSAL)
            secured.recv(1)
    except TimeoutError:
        return ""
    except ssl.SSLCertVerificationError as error:
        return f"{_fault_of_certificate(error, host, folder)} ({error.verify_message})"
    except ssl.SSLError as error:
        return (
            f"it does not take the certificate in {folder} ({error.reason}): "
            "both must be of one authority, and the clock there must be right"
        )
    return ""


def _fault_of_certificate(error: ssl.SSLCertVerificationError, host: str, folder: Path) -> str:
    """What is wrong with the certificate of the other end, with the remedy."""
    if error.verify_code == _EXPIRED:
        return "its certificate has expired, or the clock here is wrong: followspot certs host NAME --renew"
    if error.verify_code == _NOT_YET_VALID:
        return "its certificate is not valid yet: set the clock here, or there before it is made anew"
    if error.verify_code in (_OTHER_NAME, _OTHER_ADDRESS):
        return f"its certificate is for other addresses: followspot certs host NAME --renew --address {host}"
    return f"its certificate is not of the authority in {folder / 'ca.pem'}: copy its folder from there again"

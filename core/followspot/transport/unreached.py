"""Why an endpoint cannot be reached, found by a connection of its own: Zenoh tries again without a word."""

from __future__ import annotations

import re
import socket
import ssl
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from followspot.transport.greeting import greeted

_TIMEOUT = 2.0
"""Seconds that the other end has to answer."""
_ENDPOINT = re.compile(r"(?P<protocol>tcp|tls)/(?P<host>[^?#]+):(?P<port>[0-9]+)(?:[?#].*)?")
_NOT_YET_VALID, _EXPIRED = 9, 10
_OTHER_NAME, _OTHER_ADDRESS = 62, 64
"""OpenSSL's numbers of what is wrong with a certificate."""


_SILENT = "what listens there does not answer: does it hang, or wait for another protocol (tcp/, tls/)?"
_FOREIGN = "what listens there is no agent or router: is this its port, and its protocol (tcp/, tls/)?"


class Reached(NamedTuple):
    """What a connection of its own to an endpoint found.

    fault: what keeps this host from the endpoint, with the remedy, "" if nothing does;
    zid: Zenoh's id of what answers there, "" if nothing does, or if the protocol is neither tcp nor tls.
    """

    fault: str = ""
    zid: str = ""


def unreached(endpoints: Sequence[str], certificates: str) -> str:
    """Why endpoints cannot be reached, with the remedies; "" if nothing is wrong with any.

    certificates: the folder of this host's certificates, "" for none.
    """
    found = {endpoint: reach(endpoint, certificates).fault for endpoint in endpoints}
    return "; ".join(f"{endpoint}: {fault}" for endpoint, fault in found.items() if fault)


def reach(endpoint: str, certificates: str) -> Reached:
    """Whether an endpoint answers, and as whom; takes some seconds at most."""
    found = _ENDPOINT.fullmatch(endpoint)
    if found is None:
        return Reached()
    host = found["host"].strip("[]")
    try:
        with socket.create_connection((host, int(found["port"])), _TIMEOUT) as link:
            return _secured(link, host, Path(certificates)) if found["protocol"] == "tls" else _plain(link)
    except ConnectionRefusedError:
        return Reached("nothing listens there")
    except TimeoutError:
        return Reached("nothing answers: is the host there, and does a firewall let this port through?")
    except OSError as error:
        return Reached(error.strerror or str(error))


def _plain(link: socket.socket) -> Reached:
    """What answers without TLS."""
    try:
        zid = greeted(link)
    except TimeoutError:
        return Reached(_SILENT)
    except OSError:
        zid = ""
    return Reached("" if zid else _FOREIGN, zid)


def _secured(link: socket.socket, host: str, folder: Path) -> Reached:
    """What answers with TLS, or which end refuses the certificate of the other, and why."""
    context = ssl.create_default_context(cafile=folder / "ca.pem")
    context.load_cert_chain(folder / "cert.pem", folder / "key.pem", password=str)
    try:
        secured = context.wrap_socket(link, server_hostname=host)
    except TimeoutError:
        return Reached(_SILENT)
    except ssl.SSLCertVerificationError as error:
        return Reached(f"{_fault_of_certificate(error, host, folder)} ({error.verify_message})")
    except OSError as error:
        return Reached(_refusal(error, folder) if "ALERT" in _reason(error) else _FOREIGN)
    with secured:
        try:
            zid = greeted(secured)
        except TimeoutError:
            return Reached(_SILENT)
        except OSError as error:  # one of the hosts: it has a certificate of the authority
            return Reached(_refusal(error, folder))
    return Reached("" if zid else _FOREIGN, zid)


def _refusal(error: OSError, folder: Path) -> str:
    """That the other end does not take the certificate of this host."""
    return (
        f"it does not take the certificate in {folder} ({_reason(error)}): "
        "both must be of one authority, and the clock there must be right"
    )


def _reason(error: OSError) -> str:
    return (error.reason if isinstance(error, ssl.SSLError) else error.strerror) or str(error)


def _fault_of_certificate(error: ssl.SSLCertVerificationError, host: str, folder: Path) -> str:
    """What is wrong with the certificate of the other end, with the remedy."""
    if error.verify_code == _EXPIRED:
        return "its certificate has expired, or the clock here is wrong: followspot certs host NAME --renew"
    if error.verify_code == _NOT_YET_VALID:
        return "its certificate is not valid yet: set the clock here, or there before it is made anew"
    if error.verify_code in (_OTHER_NAME, _OTHER_ADDRESS):
        return f"its certificate is for other addresses: followspot certs host NAME --renew --address {host}"
    return f"its certificate is not of the authority in {folder / 'ca.pem'}: copy its folder from there again"

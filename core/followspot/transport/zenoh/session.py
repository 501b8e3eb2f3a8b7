"""A Zenoh session: a peer that logs little, and that stays on this host unless told otherwise."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import zenoh

from followspot.errors import FollowspotError
from followspot.transport.host_registry import read_certificates
from followspot.transport.unreached import unreached
from followspot.transport.zenoh.access import access_control
from followspot.transport.zenoh.network import LOOPBACK, Network

_SETTINGS: dict[str, Any] = {
    "scouting/multicast/address": "224.0.0.224:7449",  # not that of all other users of Zenoh
    "transport/shared_memory/enabled": False,  # the ring does better, and leaves nothing in /dev/shm
    "transport/link/tx/lease": 1500,  # ms until a silent peer counts as dead; a closed one is noticed at once
    "transport/unicast/open_timeout": 3000,  # ms for an attempt to connect, which a close has to wait for
    "connect/exit_on_failure": {"peer": False, "router": False, "client": True},  # start in any order
    "connect/timeout_ms": {"peer": -1, "router": -1, "client": 4000},  # -1: for ever, in the background
    "connect/retry": {"period_init_ms": 100, "period_max_ms": 1000},
    "adminspace/enabled": True,  # read-only; tells which port was free
}
_PLACE = re.compile(r" at /\S+\.rs:\d+\.?")
"""The place in Zenoh's own source that its error texts contain."""


class NoRouter(FollowspotError):
    """The router does not answer, with the reason."""


def config_of(network: Network, *, routes: bool = False) -> zenoh.Config:
    """The configuration of a session: the one place where endpoints and certificates become Zenoh's.

    Raises FollowspotError if an endpoint is none, is open to other hosts without certificates or consent, or
    these cannot be used.
    """
    network.check_endpoints()
    if network.exposed and not network.insecure:
        raise FollowspotError(
            f"{network.exposed[0]} is open to other hosts without protection; "
            "use tls/ with certificates, or say --insecure"
        )
    if network.secured and not network.certificates:
        raise FollowspotError(
            f"{network.secured[0]} needs certificates; name their folder with --certificates "
            "(followspot certs makes them)"
        )
    settings = {
        "mode": "router" if routes else "client" if network.router else "peer",
        "listen/endpoints": [] if network.router else list(network.listen),
        "connect/endpoints": [network.router] if network.router else list(network.others),
        "scouting/multicast/enabled": network.discover,  # else peers are named; gossip makes others known
        "scouting/multicast/listen": network.findable,
        **_SETTINGS,
    }
    if network.certificates:
        certificates = read_certificates(Path(network.certificates))
        settings["transport/link/tls"] = _tls(certificates.folder)
        settings["access_control"] = access_control(certificates.members)
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def connected(network: Network, *, routes: bool = False) -> zenoh.Session:
    """Open a session; close it in a `finally`, or the process never exits.

    routes: whether it forwards what other peers send to each other. Raises NoRouter if the router does not
    answer within 4 s, FollowspotError if an endpoint cannot be used.
    """
    config = config_of(network, routes=routes)
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        if network.router:
            fault = unreached([network.router], network.certificates)
            raise NoRouter(f"no router answers at {fault or network.router}") from None
        reason = _PLACE.sub("", str(error))
        raise FollowspotError(f"Zenoh cannot use {', '.join(network.endpoints)}: {reason}") from None


def connected_in_the_end(
    network: Network, log_line: Callable[[str], None], wanted: Callable[[], bool] = lambda: True
) -> zenoh.Session:
    """As `connected`, but wait for the router as long as this is `wanted`.

    log_line: gets a line for each new reason to wait. Raises NoRouter, FollowspotError.
    """
    told = ""
    while True:
        try:
            return connected(network)
        except NoRouter as error:
            if not wanted():
                raise
            if str(error) != told:
                told = str(error)
                log_line(f"{told}; waiting for it")


def close_session(session: zenoh.Session) -> None:
    """Close a session; Zenoh discards what a stuck link still holds after ten seconds."""
    with contextlib.suppress(zenoh.ZError):
        session.close()  # type: ignore[no-untyped-call]


def open_session(listen: Sequence[str] = LOOPBACK, connect: Sequence[str] = ()) -> zenoh.Session:
    """Open a peer session within this host. Raises FollowspotError."""
    return connected(Network(tuple(listen), tuple(connect)))


def locators(session: zenoh.Session) -> list[str]:
    """Endpoints at which other sessions can reach this one, with actual ports. Raises FollowspotError."""
    for reply in session.get(f"@/{session.zid()}/*", timeout=5.0):
        if reply.ok is not None:
            return [str(locator) for locator in json.loads(reply.ok.payload.to_bytes())["locators"]]
    raise FollowspotError("Zenoh does not say where it listens")


def _tls(folder: Path) -> dict[str, Any]:
    """Mutual TLS: each side shows its certificate, which the authority in the folder has signed."""
    certificate, key = str(folder / "cert.pem"), str(folder / "key.pem")
    return {
        "root_ca_certificate": str(folder / "ca.pem"),
        "listen_certificate": certificate,
        "listen_private_key": key,
        "connect_certificate": certificate,
        "connect_private_key": key,
        "enable_mtls": True,
        "close_link_on_expiration": True,
    }


def log_rejections() -> None:
    """Let Zenoh log on standard output which peers it refuses, and why; RUST_LOG overrides that."""
    zenoh.init_log_from_env_or("error,zenoh_link_tls=warn,zenoh::net::routing::interceptor=info")

"""Other hosts: the certificates to meet them with, whether agents answer, and how their clocks differ."""

from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.errors import FollowspotError
from followspot.transport.host_registry import SOON, read_certificates
from followspot_doctor.finding import Finding, doubtful, fine, wrong

if TYPE_CHECKING:
    from followspot import Network
    from followspot.control.zenoh_rpc import RpcClient
    from followspot.library.handle import ClockStatus

TIMEOUT = 3.0
"""Seconds to find agents, and to read the clock of each."""
_REMEDY = "times are corrected while a graph runs; install chrony or ptp4l on both hosts all the same"


def certificates(folder: Path) -> Iterator[Finding]:
    """Check that this host's certificates are complete, private, and valid for a while."""
    name = "certificates"
    try:
        own = read_certificates(folder).own
    except FollowspotError as error:
        yield wrong(name, str(error), "see the message; followspot certs host NAME makes a folder")
        return
    text = f"of {own.name}, {own.role}, until {own.expires:%Y-%m-%d}"
    if own.expires < datetime.now(UTC) + SOON:
        yield doubtful(name, text, f"followspot certs host {own.name} --renew, where the authority is")
    else:
        yield fine(name, text)


def agents(network: Network) -> Iterator[Finding]:
    """A finding for each host that answers; a problem if none does."""
    from followspot.control.zenoh_rpc import RpcClient
    from followspot.control.zenoh_rpc import agents as in_reach
    from followspot.transport.unreached import unreached
    from followspot.transport.zenoh.session import close_session, connected

    where = network.router or ", ".join(network.connect)
    try:
        session = connected(network)
    except FollowspotError as error:
        yield wrong("agents", str(error), "see the message")
        return
    try:
        deadline = time.monotonic() + TIMEOUT
        while not (names := in_reach(session)) and time.monotonic() < deadline:
            time.sleep(0.1)
        if not names:
            remedy = "is it started there, with that --listen? a firewall, another certificate?"
            why = unreached(network.connect, network.certificates)
            yield wrong("agents", f"none answers at {where}", why or remedy)
        for name in sorted(names):
            yield _clock(RpcClient(session, network.own), name)
    finally:
        close_session(session)


def _clock(client: RpcClient, host: str) -> Finding:
    """The difference between the clock there and the one here."""
    from followspot.host.clocks.host import HostClock

    clock = HostClock(client)
    deadline = time.monotonic() + TIMEOUT
    try:
        clock.follow(host)
        while not (found := clock.status()).exchanges and time.monotonic() < deadline:
            time.sleep(0.1)  # it goes on asking
    finally:
        clock.close()
    name = f"host {host}"
    if found.warning:
        return doubtful(name, _said(found), _REMEDY)
    answers = f"its agent answers within {found.round_trip_ms:.1f} ms"
    return fine(name, f"{answers}, its clock is {abs(found.offset_ms):.1f} ms off")


def _said(found: ClockStatus) -> str:
    if not found.exchanges:
        return "its agent does not report its clock"
    way = "ahead of" if found.offset_ms > 0 else "behind"
    within = found.round_trip_ms / 2
    return f"its clock is {abs(found.offset_ms):.1f} ms {way} this one, to within {within:.1f} ms"

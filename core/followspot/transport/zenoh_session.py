"""A Zenoh session that is quiet, meshes by itself, and stays on this host unless told otherwise."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import zenoh

from followspot.errors import FollowspotError

LOOPBACK = ("tcp/127.0.0.1:0",)
"""Listen on a free port that no other host can reach."""

_SETTINGS: dict[str, Any] = {
    "mode": "peer",
    "scouting/multicast/enabled": False,  # peers are named; those make the others known by gossip
    "transport/shared_memory/enabled": False,  # the ring does better, and leaves nothing in /dev/shm
    "transport/link/tx/lease": 3000,  # ms until a silent peer counts as dead; a closed one is noticed at once
    "connect/exit_on_failure": False,  # peers may start in any order
    "connect/timeout_ms": -1,  # for ever, in the background
    "connect/retry": {"period_init_ms": 100, "period_max_ms": 1000},
    "adminspace/enabled": True,  # read-only; tells which port was free
}


def open_session(listen: Sequence[str] = LOOPBACK, connect: Sequence[str] = ()) -> zenoh.Session:
    """Open a peer session; close it in a `finally`, or the process never exits.

    listen, connect: endpoints such as ``tcp/192.168.0.7:7447``; connections are retried until they succeed.
    Raises FollowspotError where an endpoint cannot be used.
    """
    config = zenoh.Config()
    endpoints = {"listen/endpoints": list(listen), "connect/endpoints": list(connect)}
    try:
        for key, value in (_SETTINGS | endpoints).items():
            config.insert_json5(key, json.dumps(value))
        return zenoh.open(config)
    except zenoh.ZError as error:
        where = f"listen on {', '.join(listen)} or connect to {', '.join(connect) or 'nobody'}"
        raise FollowspotError(f"Zenoh cannot {where}: {error}") from None


def locators(session: zenoh.Session) -> list[str]:
    """Where other sessions can reach this one, with the ports that were free. Raises FollowspotError."""
    for reply in session.get(f"@/{session.zid()}/peer", timeout=5.0):
        if reply.ok is not None:
            return [str(locator) for locator in json.loads(reply.ok.payload.to_bytes())["locators"]]
    raise FollowspotError("Zenoh does not say where it listens")

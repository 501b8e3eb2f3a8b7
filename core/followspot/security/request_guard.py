"""The request guard of an agent: admits each valid request of an authorised sender once; counts the others.

Zenoh's access control verifies role and name in a request's key (`followspot.transport.zenoh.access`). The
guard decides what they may do, so that a rejection has an answer, a line in the log and a count. A request
contains its agent, verb and sender, so no other host can redirect it or send it under its own name.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, Literal, NamedTuple
from uuid import uuid4

from followspot.errors import FollowspotError
from followspot.security.rejections import Rejections
from followspot.transport.keys import OPERATOR

FORMAT = 2
MAX_REQUEST = 16 << 20
"""Longest request, bytes."""
_MAX_HOST_REQUEST = 4096
"""Longest request of a host, bytes: the requests that hosts may send have no arguments."""
WINDOW = 120.0
"""Seconds by which the clocks of two hosts may differ; the guard remembers each request as long."""
MAX_REMEMBERED = 1 << 16
"""Most requests within the window; more are rejected."""
_MAX_ID = 64
STALE: Final = "stale"
"""Reason of a request whose time is too far from that of the agent."""

Reason = Literal[
    "size", "form", "version", "stale", "replayed", "flood", "verb", "role", "address", "content"
]


class Rejected(FollowspotError):
    """The guard rejects a request. reason: kind of the reason."""

    def __init__(self, reason: Reason, text: str) -> None:
        self.reason = reason
        super().__init__(text)


class Asked(NamedTuple):
    """The key of a request: agent, verb, and the sender's role and name."""

    agent: str
    verb: str
    role: str
    name: str

    @classmethod
    def of(cls, key: str) -> Asked:
        """From ``.../AGENT/VERB/ROLE/NAME``. Raises Rejected."""
        chunks = key.rsplit("/", 4)
        if len(chunks) != 5:
            raise Rejected("form", f"{key[:200]!r} is not the key of a request")
        return cls(*chunks[1:])


def envelope(asked: Asked, data: dict[str, Any], now: float | None = None) -> bytes:
    """A request with these arguments, as it is sent: valid once, now, for one agent and one sender.

    now: seconds since 1970, by the wall clock if None.
    """
    sent = time.time() if now is None else now
    fields = {"format": FORMAT, "id": uuid4().hex, "time": sent, "asked": asked, "data": data}
    return json.dumps(fields).encode()


class RequestGuard:
    """Admits or rejects the requests to an agent.

    The time of a request is compared with the wall clock, and with the wall clock as it was at the last
    request if it was set since: a run goes on then, and so does its operator.

    agent: its name; verbs: all requests that it handles; log_line: gets lines for the log; clock: wall-clock
    time, s; open_to_hosts: verbs that every registered host may use, not only operators; steady: a monotonic
    clock, s.
    """

    def __init__(
        self,
        agent: str,
        verbs: Iterable[str],
        log_line: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] = time.time,
        open_to_hosts: Iterable[str] = (),
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self._rejections = Rejections(log_line)
        self._agent = agent
        self._verbs = frozenset(verbs)
        self._open_to_hosts = frozenset(open_to_hosts)
        self._clock = clock
        self._steady = steady
        self._lead: float | None = None
        """Lead of the wall clock over the steady one, s, at the last request that was fresh by the former."""
        self._remembered: dict[str, float] = {}

    @property
    def refused(self) -> Mapping[str, int]:
        """Number of rejected requests, by reason."""
        return self._rejections.counts

    def admit(self, asked: Asked, payload: bytes) -> dict[str, Any]:
        """The arguments of a request that the guard admits. Raises Rejected; pass it to `count`."""
        if asked.verb not in self._verbs:
            raise Rejected(
                "verb", f"there is no {asked.verb[:80]!r}; known: {', '.join(sorted(self._verbs))}"
            )
        if asked.role != OPERATOR and asked.verb not in self._open_to_hosts:
            raise Rejected("role", f"{asked.role[:80]} {asked.name[:80]} may not {asked.verb}; operators may")
        found = _opened(payload, MAX_REQUEST if asked.role == OPERATOR else _MAX_HOST_REQUEST)
        if asked.agent != self._agent or found["asked"] != list(asked):
            raise Rejected(
                "address",
                f"the request is addressed {'/'.join(found['asked'])[:200]!r}, "
                f"and came to {self._agent} as {'/'.join(asked)[:200]!r}",
            )
        if asked.verb not in self._open_to_hosts:  # repeating the others is harmless
            self._remember(found["id"], float(found["time"]))
        return dict(found["data"])

    def count(self, sender: str, error: Rejected) -> None:
        """Count and log a rejection. sender: the key of the request."""
        self._rejections.add(error.reason, sender, str(error))

    def sum_up(self) -> None:
        """Log the number of rejected requests."""
        self._rejections.sum_up("requests")

    def _remember(self, name: str, sent: float) -> None:
        """Remember a request. Raises Rejected if it is too old or was received before."""
        now, steady = self._clock(), self._steady()
        before = now if self._lead is None else steady + self._lead
        fresh = abs(now - sent) <= WINDOW
        if not (fresh or abs(before - sent) <= WINDOW):
            raise Rejected(
                STALE,
                f"the request is {now - sent:.0f} s old by the clock here, {WINDOW:.0f} s are allowed; "
                "set the clocks of both hosts",
            )
        if name in self._remembered:
            raise Rejected("replayed", "the request was received before")
        if len(self._remembered) >= MAX_REMEMBERED:
            earlier = min(now, before)
            self._remembered = {seen: until for seen, until in self._remembered.items() if until >= earlier}
            if len(self._remembered) >= MAX_REMEMBERED:
                raise Rejected("flood", f"more than {MAX_REMEMBERED} requests in {2 * WINDOW:.0f} s")
        self._remembered[name] = sent + WINDOW
        if fresh:
            self._lead = now - steady


def _opened(payload: bytes, most: int) -> dict[str, Any]:
    """The validated content of an envelope. most: bytes. Raises Rejected."""
    if len(payload) > most:
        raise Rejected("size", f"a request of {len(payload)} bytes, at most {most} allowed")
    try:
        found = json.loads(payload)
    except (ValueError, RecursionError) as error:
        raise Rejected("form", f"the request is not JSON: {str(error)[:200]}") from None
    if not isinstance(found, dict):
        raise Rejected("form", "a request is a JSON object")
    if found.get("format") != FORMAT:
        raise Rejected("version", f"a request of format {str(found.get('format'))[:80]}, this is {FORMAT}")
    name, sent, data, asked = (found.get(part) for part in ("id", "time", "data", "asked"))
    if not (isinstance(name, str) and 16 <= len(name) <= _MAX_ID and isinstance(data, dict)):
        raise Rejected("form", "a request has an id of 16 to 64 characters and an object as data")
    if isinstance(sent, bool) or not isinstance(sent, int | float) or not abs(sent) < 1e12:
        raise Rejected("form", "a request has a time, seconds since 1970")
    if not (isinstance(asked, list) and all(isinstance(word, str) for word in asked)):
        raise Rejected("form", "a request says which agent is asked for what, and by whom")
    return found

"""Which requests an agent takes: each once, fresh, well-formed, from who may ask; the others it counts.

Zenoh's access control vouches for role and name in a request's key (`followspot.transport.zenoh.access`);
what they may do is decided here, so that a refusal has an answer, a line in the log and a count. A request
says to whom it goes, what for and who sends it, so nobody can give it to another agent, or as its own.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, NamedTuple
from uuid import uuid4

from followspot.errors import FollowspotError
from followspot.security.rejections import Rejections
from followspot.transport.keys import OPERATOR

FORMAT = 2
MAX_REQUEST = 16 << 20
"""Longest request, bytes."""
_MAX_QUESTION = 4096
"""Longest of those who are no operators, bytes: what they may ask has no arguments."""
WINDOW = 120.0
"""Seconds by which the clocks of two hosts may differ; each request is remembered for as long."""
MAX_REMEMBERED = 1 << 16
"""Most requests within the window; more are refused."""
_MAX_ID = 64

Reason = Literal[
    "size", "form", "version", "stale", "replayed", "flood", "verb", "role", "address", "content"
]


class Rejected(FollowspotError):
    """A request that is not taken, and the kind of reason."""

    def __init__(self, reason: Reason, text: str) -> None:
        self.reason = reason
        super().__init__(text)


class Asked(NamedTuple):
    """Who asks which agent for what, as the key of the request says."""

    agent: str
    verb: str
    role: str
    name: str

    @classmethod
    def of(cls, key: str) -> Asked:
        """From ``.../AGENT/VERB/ROLE/NAME``. Raises Refused."""
        chunks = key.rsplit("/", 4)
        if len(chunks) != 5:
            raise Rejected("form", f"{key[:200]!r} is not the key of a request")
        return cls(*chunks[1:])


def seal(asked: Asked, data: dict[str, Any]) -> bytes:
    """A request with these arguments, to be sent once, now, to one agent, under one name."""
    envelope = {"format": FORMAT, "id": uuid4().hex, "time": time.time(), "asked": asked, "data": data}
    return json.dumps(envelope).encode()


class RequestGuard:
    """An agent's gate.

    agent: its name; verbs: what can be asked; tell: gets lines for the log; clock: wall-clock time, s;
    open_to_hosts: verbs that every host on the list may ask, not operators alone.
    """

    def __init__(
        self,
        agent: str,
        verbs: Iterable[str],
        tell: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] = time.time,
        open_to_hosts: Iterable[str] = (),
    ) -> None:
        self._refusals = Rejections(tell)
        self._agent = agent
        self._verbs = frozenset(verbs)
        self._open_to_hosts = frozenset(open_to_hosts)
        self._clock = clock
        self._seen: dict[str, float] = {}

    @property
    def refused(self) -> Mapping[str, int]:
        """How many requests were refused, by reason."""
        return self._refusals.counts

    def admit(self, asked: Asked, payload: bytes) -> dict[str, Any]:
        """The arguments of a request that may be answered. Raises Refused, to be given to `count`."""
        if asked.verb not in self._verbs:
            raise Rejected(
                "verb", f"there is no {asked.verb[:80]!r}; known: {', '.join(sorted(self._verbs))}"
            )
        if asked.role != OPERATOR and asked.verb not in self._open_to_hosts:
            raise Rejected("role", f"{asked.role[:80]} {asked.name[:80]} may not {asked.verb}; operators may")
        found = _opened(payload, MAX_REQUEST if asked.role == OPERATOR else _MAX_QUESTION)
        if asked.agent != self._agent or found["asked"] != list(asked):
            raise Rejected(
                "address",
                f"the request is addressed {'/'.join(found['asked'])[:200]!r}, "
                f"and came to {self._agent} as {'/'.join(asked)[:200]!r}",
            )
        if asked.verb not in self._open_to_hosts:  # a repetition is harmless
            self._remember(found["id"], float(found["time"]))
        return dict(found["data"])

    def count(self, who: str, error: Rejected) -> None:
        """Count and log a refusal; who: the key of the request."""
        self._refusals.add(error.reason, who, str(error))

    def sum_up(self) -> None:
        """Log how many were refused."""
        self._refusals.sum_up("requests")

    def _remember(self, name: str, sent: float) -> None:
        """Raises Refused where the request is old, or was here before."""
        now = self._clock()
        if not abs(now - sent) <= WINDOW:
            raise Rejected(
                "stale",
                f"the request is {now - sent:.0f} s old by the clock here, {WINDOW:.0f} s are allowed; "
                "set the clocks of both hosts",
            )
        if name in self._seen:
            raise Rejected("replayed", "the request was here before")
        if len(self._seen) >= MAX_REMEMBERED:
            self._seen = {seen: until for seen, until in self._seen.items() if until >= now}
            if len(self._seen) >= MAX_REMEMBERED:
                raise Rejected("flood", f"more than {MAX_REMEMBERED} requests in {2 * WINDOW:.0f} s")
        self._seen[name] = sent + WINDOW


def _opened(payload: bytes, most: int) -> dict[str, Any]:
    """The envelope, checked; most: bytes. Raises Refused."""
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

"""Which requests an agent takes: each once, fresh, well-formed, from who may ask; the others it counts.

Zenoh's access control vouches for role and name in a request's key (`followspot.transport.access`);
what they may do is decided here, so that a refusal has an answer, a line in the log and a count.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, NamedTuple
from uuid import uuid4

from followspot.deploy.security.refusals import Refusals
from followspot.errors import FollowspotError
from followspot.transport.keys import OPERATOR

FORMAT = 1
MAX_REQUEST = 16 << 20
"""Longest request, bytes."""
WINDOW = 120.0
"""Seconds by which the clocks of two hosts may differ; each request is remembered for as long."""
MAX_REMEMBERED = 1 << 16
"""Most requests within the window; more are refused."""
_MAX_ID = 64

_FOR_ALL = frozenset({"clock"})
"""What every host on the list may ask."""

Reason = Literal["size", "form", "version", "stale", "replayed", "flood", "verb", "role", "content"]


class Refused(FollowspotError):
    """A request that is not taken, and the kind of reason."""

    def __init__(self, reason: Reason, text: str) -> None:
        self.reason = reason
        super().__init__(text)


class Asked(NamedTuple):
    """Who asks an agent for what, as the key of the request says."""

    verb: str
    role: str
    name: str

    @classmethod
    def of(cls, key: str) -> Asked:
        """From ``.../VERB/ROLE/NAME``. Raises Refused."""
        chunks = key.rsplit("/", 3)
        if len(chunks) != 4:
            raise Refused("form", f"{key[:200]!r} is not the key of a request")
        return cls(*chunks[1:])


def seal(data: dict[str, Any]) -> bytes:
    """A request with these arguments, to be sent once, now."""
    return json.dumps({"format": FORMAT, "id": uuid4().hex, "time": time.time(), "data": data}).encode()


class Admission:
    """An agent's gate.

    verbs: what can be asked; tell: gets lines for the log; clock: wall-clock time, s.
    """

    def __init__(
        self,
        verbs: Iterable[str],
        tell: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self._refusals = Refusals(tell)
        self._verbs = frozenset(verbs)
        self._clock = clock
        self._seen: dict[str, float] = {}

    @property
    def refused(self) -> Mapping[str, int]:
        """How many requests were refused, by reason."""
        return self._refusals.counts

    def admit(self, asked: Asked, payload: bytes) -> dict[str, Any]:
        """The arguments of a request that may be answered. Raises Refused, to be given to `count`."""
        if asked.verb not in self._verbs:
            raise Refused("verb", f"there is no {asked.verb[:80]!r}; known: {', '.join(sorted(self._verbs))}")
        if asked.role != OPERATOR and asked.verb not in _FOR_ALL:
            raise Refused("role", f"{asked.role[:80]} {asked.name[:80]} may not {asked.verb}; operators may")
        found = _opened(payload)
        self._remember(found["id"], float(found["time"]))
        return dict(found["data"])

    def count(self, who: str, error: Refused) -> None:
        """Count and log a refusal; who: the key of the request."""
        self._refusals.add(error.reason, who, str(error))

    def sum_up(self) -> None:
        """Log how many were refused."""
        self._refusals.sum_up("requests")

    def _remember(self, name: str, sent: float) -> None:
        """Raises Refused where the request is old, or was here before."""
        now = self._clock()
        if not abs(now - sent) <= WINDOW:
            raise Refused(
                "stale",
                f"the request is {now - sent:.0f} s old by the clock here, {WINDOW:.0f} s are allowed; "
                "set the clocks of both hosts",
            )
        if name in self._seen:
            raise Refused("replayed", "the request was here before")
        if len(self._seen) >= MAX_REMEMBERED:
            self._seen = {seen: until for seen, until in self._seen.items() if until >= now}
            if len(self._seen) >= MAX_REMEMBERED:
                raise Refused("flood", f"more than {MAX_REMEMBERED} requests in {2 * WINDOW:.0f} s")
        self._seen[name] = sent + WINDOW


def _opened(payload: bytes) -> dict[str, Any]:
    """The envelope, checked. Raises Refused."""
    if len(payload) > MAX_REQUEST:
        raise Refused("size", f"a request of {len(payload)} bytes, at most {MAX_REQUEST} allowed")
    try:
        found = json.loads(payload)
    except (ValueError, RecursionError) as error:
        raise Refused("form", f"the request is not JSON: {str(error)[:200]}") from None
    if not isinstance(found, dict):
        raise Refused("form", "a request is a JSON object")
    if found.get("format") != FORMAT:
        raise Refused("version", f"a request of format {str(found.get('format'))[:80]}, this is {FORMAT}")
    name, sent, data = found.get("id"), found.get("time"), found.get("data")
    if not (isinstance(name, str) and 16 <= len(name) <= _MAX_ID and isinstance(data, dict)):
        raise Refused("form", "a request has an id of 16 to 64 characters and an object as data")
    if isinstance(sent, bool) or not isinstance(sent, int | float) or not abs(sent) < 1e12:
        raise Refused("form", "a request has a time, seconds since 1970")
    return found

"""The carrier of requests to agents over Zenoh: JSON both ways, one key for each verb and client.

`followspot.transport.keys` defines the keys, `followspot.security.request_guard` the requests that an agent
accepts.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pydantic
import zenoh
from zenoh.handlers import Callback

from followspot.control.dispatch import Dispatcher, Request, answer_from_wire, fields, verb
from followspot.control.host import HostLost, HostRefused, HostRefusedTime
from followspot.control.observation import ReadClock
from followspot.errors import FollowspotError
from followspot.security.request_clock import RequestClock
from followspot.security.request_guard import MAX_REQUEST, STALE, Asked, Rejected, RequestGuard, envelope
from followspot.transport.keys import agent_key, request_key
from followspot.transport.zenoh.network import Own

MAX_ANSWER = 4 << 20
"""Longest answer, bytes."""
MAX_PART = MAX_REQUEST
"""Longest answer that later requests carry, bytes."""
MAX_REASON = 20_000
"""Longest reason of a refusal, characters: enough for a list of many mistakes."""
MAX_WAITING = 256
"""Most requests that wait for an answer; more are refused."""
MAX_WAITING_BYTES = 4 * MAX_REQUEST


class InvalidAnswer(FollowspotError):
    """The answer of a host is invalid. why: the first fault in it."""

    def __init__(self, agent: str, verb: str, why: str) -> None:
        self.why = why
        super().__init__(f"host {agent}: its answer to {verb} is invalid: {why}")


@dataclass(frozen=True)
class RpcClient:
    """Sends requests to agents. session: Zenoh session; own: role and name of the client."""

    session: zenoh.Session
    own: Own
    _clocks: dict[str, RequestClock] = field(default_factory=dict, init=False, compare=False)
    """The clock that requests to an agent go by."""

    def ask(self, agent: str, request: Request, timeout: float = 2.0) -> Any:
        """An agent's answer to a request. timeout: s.

        Raises HostLost after the timeout, HostRefused if the agent refuses, InvalidAnswer or another
        FollowspotError if the answer is invalid.
        """
        clock = self._clocks.setdefault(agent, RequestClock())
        try:
            return self._ask(agent, request, timeout, clock.now())
        except HostRefusedTime:
            other = clock.other()
            if other is None:
                raise
        answer = self._ask(agent, request, timeout, other.now())
        self._clocks[agent] = other
        return answer

    def _ask(self, agent: str, request: Request, timeout: float, now: float) -> Any:
        """The answer to a request that says this time, s since 1970. Raises as `ask`."""
        kind = type(request)
        asked = Asked(agent, verb(kind), *self.own)
        payload = envelope(asked, fields(request), now)
        for reply in self.session.get(request_key(*asked), payload=payload, timeout=timeout):
            if reply.ok is None:
                continue
            answer = _answer(agent, reply.ok.payload, MAX_PART if kind.long_answer else MAX_ANSWER)
            try:
                return answer_from_wire(kind, answer)
            except pydantic.ValidationError as error:
                first = error.errors()[0]
                why = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
                raise InvalidAnswer(agent, verb(kind), why) from None
        raise HostLost(f"host {agent} does not answer")

    def has_twins(self, agent: str, timeout: float = 2.0) -> bool:
        """Whether several agents of this name answer; each request would reach all of them. timeout: s."""
        asked = Asked(agent, verb(ReadClock), *self.own)
        payload = envelope(asked, fields(ReadClock(run="")))
        each = zenoh.ConsolidationMode.NONE  # else one of the answers takes the place of the others
        replies = self.session.get(request_key(*asked), payload=payload, timeout=timeout, consolidation=each)
        return sum(1 for reply in replies if reply.ok is not None) > 1


def _answer(agent: str, payload: zenoh.ZBytes, most: int) -> Any:
    """The answer in JSON types. most: bytes. Raises HostRefused, or FollowspotError if it is invalid."""
    if len(payload) > most:
        raise FollowspotError(f"host {agent}: its answer has {len(payload)} bytes, {most} are allowed")
    try:
        said = json.loads(payload.to_bytes())
    except (ValueError, RecursionError) as error:
        raise FollowspotError(f"host {agent}: its answer is not JSON: {str(error)[:200]}") from None
    if not isinstance(said, dict) or not said.keys() & {"answer", "refused"}:
        raise FollowspotError(f"host {agent}: it sent neither an answer nor a refusal: {str(said)[:200]}")
    if "refused" in said:
        refused = HostRefusedTime if said.get("reason") == STALE else HostRefused
        raise refused(f"host {agent}: {str(said['refused'])[:MAX_REASON]}")
    return said["answer"]


def agents(session: zenoh.Session, timeout: float = 1.0) -> set[str]:
    """Names of the agents that are alive."""
    replies = session.liveliness().get(agent_key("*"), timeout=timeout)
    return {str(reply.ok.key_expr).rpartition("/")[2] for reply in replies if reply.ok is not None}


class RpcServer:
    """The agent's side: requests wait until the agent's thread answers them.

    dispatcher: has the agent's handlers; wake: wakes the agent's thread, called from Zenoh's threads;
    log_line: gets a line for each refusal.
    """

    def __init__(
        self,
        session: zenoh.Session,
        agent: str,
        dispatcher: Dispatcher,
        wake: Callable[[], None],
        log_line: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._dispatcher = dispatcher
        self._wake = wake
        self._waiting: deque[zenoh.Query] = deque()
        self._bytes = self._dropped = 0
        self._lock = threading.Lock()
        open_to_hosts = (name for name, kind in dispatcher.kinds.items() if kind.open_to_hosts)
        self.guard = RequestGuard(agent, dispatcher.kinds, log_line, open_to_hosts=open_to_hosts)
        self._declared: list[Any] = [
            session.declare_queryable(
                request_key(agent, "*", "*", "*"), Callback(self._arrived, indirect=False)
            ),
            session.liveliness().declare_token(agent_key(agent)),
        ]

    def answer(self) -> None:
        """Answer all waiting requests."""
        while self._waiting:
            query = self._waiting.popleft()
            payload = b"" if query.payload is None else query.payload.to_bytes()
            with self._lock:
                self._bytes -= len(payload)
            key = str(query.key_expr)
            try:
                said = {"answer": self._answer_to(Asked.of(key), payload)}
            except Rejected as error:
                self.guard.count(key, error)
                said = {"refused": str(error), "reason": error.reason}
            _reply(query, said)
        with self._lock:
            dropped, self._dropped = self._dropped, 0
        if dropped:
            self.guard.count("?", Rejected("flood", f"{dropped} requests at once were too many or too large"))

    def close(self) -> None:
        """Stop answering; log the counts of refusals."""
        for declared in reversed(self._declared):
            declared.undeclare()
        self._waiting.clear()
        self.guard.sum_up()

    def _answer_to(self, asked: Asked, payload: bytes) -> Any:
        data = self.guard.admit(asked, payload)
        try:
            return self._dispatcher.dispatch_wire({**data, "verb": asked.verb})
        except Exception as error:  # no request may end the agent's runs
            raise Rejected("content", str(error) or type(error).__name__) from error

    def _arrived(self, query: zenoh.Query) -> None:
        size = 0 if query.payload is None else len(query.payload)
        with self._lock:
            if len(self._waiting) < MAX_WAITING and self._bytes + size <= MAX_WAITING_BYTES:
                self._bytes += size
                self._waiting.append(query)
            else:
                self._dropped += 1
        self._wake()


def _reply(query: zenoh.Query, said: dict[str, Any]) -> None:
    try:
        query.reply(query.key_expr, json.dumps(said).encode())
    except zenoh.ZError:
        return  # the client is gone

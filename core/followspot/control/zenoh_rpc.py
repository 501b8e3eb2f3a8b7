"""Requests to agents over Zenoh: one key a verb and asker, JSON both ways, an answer or the reason why not.

The keys stand in `followspot.transport.keys`, what is taken in `followspot.security.guard`.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import zenoh
from zenoh.handlers import Callback

from followspot.control.host import HostLost, HostRefused
from followspot.errors import FollowspotError
from followspot.security.request_guard import MAX_REQUEST, Asked, Rejected, RequestGuard, seal
from followspot.transport.keys import agent_key, request_key
from followspot.transport.zenoh.network import Own

MAX_ANSWER = 4 << 20
"""Longest answer, bytes."""
MAX_PART = MAX_REQUEST
"""Longest answer that tells what goes back in a request: the order of a run, the states of its stages."""
_WHOLE = frozenset({"order", "states"})
MAX_REASON = 20_000
"""Longest reason of a refusal, characters: a report of many mistakes."""
MAX_WAITING = 256
"""Most requests that wait for an answer; more are refused."""
MAX_WAITING_BYTES = 4 * MAX_REQUEST


@dataclass(frozen=True)
class RpcClient:
    """Who asks agents: a session, and the role and name that it speaks under."""

    session: zenoh.Session
    own: Own

    def ask(self, agent: str, verb: str, timeout: float = 2.0, **data: Any) -> Any:
        """An agent's answer. Raises HostLost where none comes, HostRefused where it does not do that.

        Whatever a host sends that is no answer is a FollowspotError, too.
        """
        asked = Asked(agent, verb, *self.own)
        for reply in self.session.get(request_key(*asked), payload=seal(asked, data), timeout=timeout):
            if reply.ok is None:
                continue
            return _answer(agent, reply.ok.payload, MAX_PART if verb in _WHOLE else MAX_ANSWER)
        raise HostLost(f"host {agent} does not answer")


def _answer(agent: str, payload: zenoh.ZBytes, most: int) -> Any:
    """most: bytes. Raises HostRefused where it is a refusal, FollowspotError where it is no answer at all."""
    if len(payload) > most:
        raise FollowspotError(f"host {agent}: its answer has {len(payload)} bytes, {most} are allowed")
    try:
        said = json.loads(payload.to_bytes())
    except (ValueError, RecursionError) as error:
        raise FollowspotError(f"host {agent}: its answer is not JSON: {str(error)[:200]}") from None
    if not isinstance(said, dict) or not said.keys() & {"answer", "refused"}:
        raise FollowspotError(f"host {agent}: its answer is none: {str(said)[:200]}")
    if "refused" in said:
        raise HostRefused(f"host {agent}: {str(said['refused'])[:MAX_REASON]}")
    return said["answer"]


def agents(session: zenoh.Session, timeout: float = 1.0) -> set[str]:
    """Names of the agents that are there."""
    replies = session.liveliness().get(agent_key("*"), timeout=timeout)
    return {str(reply.ok.key_expr).rpartition("/")[2] for reply in replies if reply.ok is not None}


class RpcServer:
    """The agent's side: requests wait until its one thread answers them.

    verbs: functions of a request's data that return JSON types, or raise FollowspotError to refuse;
    ring: wakes the agent's thread, from another one; tell: gets a line for each refusal.
    """

    def __init__(
        self,
        session: zenoh.Session,
        agent: str,
        verbs: Mapping[str, Callable[..., Any]],
        ring: Callable[[], None],
        tell: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._verbs = verbs
        self._ring = ring
        self._waiting: deque[zenoh.Query] = deque()
        self._bytes = self._flooded = 0
        self._lock = threading.Lock()
        self.guard = RequestGuard(agent, verbs, tell)
        self._declared: list[Any] = [
            session.declare_queryable(
                request_key(agent, "*", "*", "*"), Callback(self._arrived, indirect=False)
            ),
            session.liveliness().declare_token(agent_key(agent)),
        ]

    def answer(self) -> None:
        """Answer all requests that wait."""
        while self._waiting:
            query = self._waiting.popleft()
            payload = b"" if query.payload is None else query.payload.to_bytes()
            with self._lock:
                self._bytes -= len(payload)
            key = str(query.key_expr)
            try:
                said = {"answer": self._said(Asked.of(key), payload)}
            except Rejected as error:
                self.guard.count(key, error)
                said = {"refused": str(error)}
            _reply(query, said)
        with self._lock:
            flooded, self._flooded = self._flooded, 0
        if flooded:
            self.guard.count("?", Rejected("flood", f"{flooded} requests at once were too many or too large"))

    def close(self) -> None:
        """Answer nothing more; log how much was refused."""
        for declared in reversed(self._declared):
            declared.undeclare()
        self._waiting.clear()
        self.guard.sum_up()

    def _said(self, asked: Asked, payload: bytes) -> Any:
        data = self.guard.admit(asked, payload)
        try:
            return self._verbs[asked.verb](**data)
        except Exception as error:  # whatever a request makes of this, the runs here go on
            raise Rejected("content", str(error) or type(error).__name__) from error

    def _arrived(self, query: zenoh.Query) -> None:
        size = 0 if query.payload is None else len(query.payload)
        with self._lock:
            if len(self._waiting) < MAX_WAITING and self._bytes + size <= MAX_WAITING_BYTES:
                self._bytes += size
                self._waiting.append(query)
            else:
                self._flooded += 1
        self._ring()


def _reply(query: zenoh.Query, said: dict[str, Any]) -> None:
    try:
        query.reply(query.key_expr, json.dumps(said).encode())
    except zenoh.ZError:
        return  # who asked is gone

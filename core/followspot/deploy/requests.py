"""Requests to agents over Zenoh: one key a verb, JSON both ways, an answer or the reason why not.

Keys: ``followspot/agent/NAME`` is the agent's liveliness token, ``followspot/agent/NAME/VERB`` what it
answers. One key a verb lets access control tell those who may look from those who may start and stop.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

import zenoh
from zenoh.handlers import Callback

from followspot.deploy.host import HostLost
from followspot.errors import FollowspotError

AGENTS = "followspot/agent"
MAX_REQUEST = 16 << 20
"""Longest request, bytes."""
MAX_WAITING = 256
"""Most requests that wait for an answer; more are refused."""


def ask(session: zenoh.Session, agent: str, verb: str, timeout: float = 2.0, **data: Any) -> Any:
    """An agent's answer. Raises HostLost where none comes, FollowspotError where the agent refuses."""
    payload = json.dumps(data).encode()
    for reply in session.get(f"{AGENTS}/{agent}/{verb}", payload=payload, timeout=timeout):
        if reply.ok is None:
            continue
        answer = json.loads(reply.ok.payload.to_bytes())
        if "refused" in answer:
            raise FollowspotError(f"host {agent}: {answer['refused']}")
        return answer["answer"]
    raise HostLost(f"host {agent} does not answer")


def agents(session: zenoh.Session, timeout: float = 1.0) -> set[str]:
    """Names of the agents that are there."""
    replies = session.liveliness().get(f"{AGENTS}/*", timeout=timeout)
    return {str(reply.ok.key_expr).rpartition("/")[2] for reply in replies if reply.ok is not None}


class Answers:
    """The agent's side: requests wait until its one thread answers them.

    verbs: functions of a request's data that return JSON types, or raise FollowspotError to refuse;
    ring: wakes the agent's thread, from another one.
    """

    def __init__(
        self,
        session: zenoh.Session,
        agent: str,
        verbs: Mapping[str, Callable[..., Any]],
        ring: Callable[[], None],
    ) -> None:
        self._verbs = verbs
        self._ring = ring
        self._waiting: deque[zenoh.Query] = deque()
        self.refused = 0
        """Requests that were refused."""
        key = f"{AGENTS}/{agent}"
        self._declared: list[Any] = [
            session.declare_queryable(f"{key}/*", Callback(self._arrived, indirect=False)),
            session.liveliness().declare_token(key),
        ]

    def answer(self) -> None:
        """Answer all requests that wait."""
        while self._waiting:
            query = self._waiting.popleft()
            verb = str(query.key_expr).rpartition("/")[2]
            try:
                said = {"answer": self._verbs[verb](**_data(query))}
            except (FollowspotError, ValueError, TypeError, KeyError, OSError) as error:
                self.refused += 1
                said = {"refused": str(error) or type(error).__name__}
            _reply(query, said)

    def close(self) -> None:
        """Answer nothing more."""
        for declared in reversed(self._declared):
            declared.undeclare()
        self._waiting.clear()

    def _arrived(self, query: zenoh.Query) -> None:
        if len(self._waiting) < MAX_WAITING:
            self._waiting.append(query)
        self._ring()


def _data(query: zenoh.Query) -> dict[str, Any]:
    """What the request says. Raises ValueError."""
    payload = b"{}" if query.payload is None else query.payload.to_bytes()
    if len(payload) > MAX_REQUEST:
        raise ValueError(f"a request of {len(payload)} bytes, at most {MAX_REQUEST} allowed")
    data = json.loads(payload)
    if not isinstance(data, dict):
        raise ValueError("a request is a JSON object")
    return data


def _reply(query: zenoh.Query, said: dict[str, Any]) -> None:
    try:
        query.reply(query.key_expr, json.dumps(said).encode())
    except zenoh.ZError:
        return  # who asked is gone

"""Makes the ends of a worker's edges over Zenoh, and the keys of their ports."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.messages import Message
from followspot.transport.keys import port_key

if TYPE_CHECKING:
    import zenoh

    from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter

_MATCH_TIMEOUT = 45.0
"""Seconds for all Zenoh edges of a run to find their other ends; workers of a busy host start slowly."""


class ZenohEdgeFactory:
    """Makes the ends of edges over Zenoh, and keeps all that it has made.

    session: None if no edge of the worker goes over Zenoh; run: name that keeps the keys of two runs apart;
    incarnation: how often the worker was started before.
    """

    def __init__(self, session: zenoh.Session | None, run: str, incarnation: int) -> None:
        self.session = session
        self.run = run
        self.incarnation = incarnation
        self._ends: list[tuple[str, ZenohReader | ZenohWriter]] = []

    def reader(self, plan: Plan, edge: int, kind: type[Message], depth: int) -> ZenohReader:
        """The reading end of one edge; depth: most messages on their way to it."""
        from followspot.transport.zenoh.edge import ZenohReader

        assert self.session is not None
        planned = plan.edge(edge)
        reader = ZenohReader(
            self.session,
            self._key(plan, edge),
            str(edge),
            kind,
            depth,
            codec=planned.codec,
            host=plan.host_of_stage(planned.to_stage),
            incarnation=self.incarnation,
        )
        self._ends.append((planned.name, reader))
        return reader

    def writer(self, plan: Plan, edges: Sequence[int], depth: int) -> ZenohWriter:
        """The writing end of alike edges of one output port; depth: see `reader`, for the slowest."""
        from followspot.transport.zenoh.edge import ZenohWriter

        assert self.session is not None
        first = plan.edge(edges[0])
        writer = ZenohWriter(
            self.session,
            self._key(plan, edges[0]),
            {str(edge): plan.host_of_stage(plan.edge(edge).to_stage) for edge in edges},
            depth,
            codec=first.codec,
            incarnation=self.incarnation,
        )
        self._ends.append((first.name, writer))
        return writer

    def adopt(self, new: ZenohEdgeFactory) -> None:
        """Take over the ends that another factory has made."""
        self._ends += new._ends

    def wait_matched(self, wanted: Callable[[], bool]) -> None:
        """Block until every edge has found its other end, so that nothing is lost at the start.

        wanted: called repeatedly; the wait ends when it returns False. Raises FollowspotError that names the
        edges without another end.
        """
        deadline = time.monotonic() + _MATCH_TIMEOUT
        waiting = self._ends
        while waiting and wanted():
            waiting = [(name, end) for name, end in waiting if not end.matched()]
            if waiting and time.monotonic() > deadline:
                names = ", ".join(sorted({name for name, _ in waiting}))
                raise FollowspotError(f"Zenoh found no other end for {names} within {_MATCH_TIMEOUT:.0f} s")
            if waiting:
                time.sleep(0.005)

    def announce_again(self) -> None:
        """Announce all ends again: other workers that wait for them may have missed it."""
        for _, end in self._ends:
            end.matched()

    def rejected(self) -> Iterator[tuple[str, int]]:
        """Name of each edge, and how many messages it got that are malformed or not from its other end."""
        for name, end in self._ends:
            yield name, end.rejected

    def forget(self) -> None:
        """Close all ends: the graph does not get their edges after all."""
        for _, end in self._ends:
            end.close()
        self._ends = []

    def close(self) -> None:
        """Close the session; the ends were closed by their worker."""
        if self.session is not None:
            from followspot.transport.zenoh.session import close_session

            close_session(self.session)
            self.session = None

    def _key(self, plan: Plan, edge: int) -> str:
        """Key of the edge's port, or one of its own if it carries other messages than the first edges.

        An edge that drops carries fewer, and one that came while the run went on begins later.
        """
        planned = plan.edge(edge)
        host = plan.host_of_stage(planned.from_stage)
        port = port_key(self.run, host, planned.from_stage, planned.from_port)
        if planned.drops:
            return f"{port}/{planned.policy}/{edge}"
        addition = plan.addition(edge)
        return f"{port}/added/{addition}" if addition else port

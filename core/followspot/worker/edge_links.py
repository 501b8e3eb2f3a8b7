"""The ends of edges between workers: rings over socket pairs, and Zenoh keys."""

from __future__ import annotations

import socket
import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from followspot.control.worker_orders import TakeRing
from followspot.errors import FollowspotError
from followspot.graph.plan import AHEAD, EdgeKind, Plan, PlannedEdge
from followspot.messages import Message
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.keys import port_key
from followspot.transport.ring.links import Home
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.worker.ledger import COLUMNS
from followspot.worker.scheduler import Scheduler

if TYPE_CHECKING:
    import zenoh

    from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter

_MATCH_TIMEOUT = 45.0
"""Seconds for all Zenoh edges of a run to find their other ends; workers of a busy host start slowly."""


class EdgeLinks:
    """Makes the ends of a worker's edges.

    sending, receiving: this worker's ends of the ring edges' socket pairs, by edge number;
    session: open if the worker has Zenoh edges; run: name that keeps the keys of two runs apart;
    incarnation: how often the worker was started before.
    """

    def __init__(
        self,
        plan: Plan,
        sending: Mapping[int, socket.socket],
        receiving: Mapping[int, socket.socket],
        session: zenoh.Session | None,
        run: str,
        incarnation: int = 0,
    ) -> None:
        self.plan = self._working = plan
        """The plan whose edges these links make. `_working`: the plan of the edges that work."""
        self.sending = dict(sending)
        self.receiving = dict(receiving)
        self.session = session
        self.run = run
        self.incarnation = incarnation
        self._ring_readers: dict[int, tuple[RingReader, type[Message]]] = {}
        self._ring_writers: dict[int, tuple[RingWriter | DroppingWriter, int]] = {}
        self._zenoh_ends: list[tuple[str, ZenohReader | ZenohWriter]] = []
        self._refused: Counter[str] = Counter()
        """Refusals of ends that were replaced since, by edge."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """The reading end of one edge."""
        planned = self.plan.edge(edge)
        if planned.kind == "ring":
            return self._ring_reader(edge, self.receiving[edge], kind)
        from followspot.transport.zenoh.edge import ZenohReader

        assert self.session is not None
        reader = ZenohReader(
            self.session,
            self._key(edge),
            str(edge),
            kind,
            self._depth([planned]),
            codec=planned.codec,
            host=self.plan.host_of_stage(planned.to_stage),
            incarnation=self.incarnation,
        )
        self._zenoh_ends.append((planned.name, reader))
        return reader

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """The writing end of all edges of one output port that have the same kind, codec and policy."""
        planned = [self.plan.edge(edge) for edge in edges]
        drops = planned[0].drops and self.plan.live
        if kind == "ring":
            ring: RingWriter | DroppingWriter = RingWriter(
                [self.sending[edge] for edge in edges], self._depth(planned), self._homes(edges)
            )
            ring = DroppingWriter(ring, planned[0].depth) if drops else ring
            self._ring_writers.update({edge: (ring, index) for index, edge in enumerate(edges)})
            return ring
        from followspot.transport.zenoh.edge import ZenohWriter

        assert self.session is not None
        readers = {str(edge): self.plan.host_of_stage(self.plan.edge(edge).to_stage) for edge in edges}
        writer = ZenohWriter(
            self.session,
            self._key(edges[0]),
            readers,
            self._depth(planned),
            codec=planned[0].codec,
            incarnation=self.incarnation,
        )
        self._zenoh_ends.append((planned[0].name, writer))
        return DroppingWriter(writer, planned[0].depth) if drops else writer

    def take(self, scheduler: Scheduler, order: TakeRing, sock: socket.socket) -> None:
        """Take one end of a ring: of an edge that works already, or of one that the graph is to get."""
        if order.edge in self._ring_readers or order.edge in self._ring_writers:
            self.renew(scheduler, order.edge, sock)
        else:
            (self.sending if order.side == "sending" else self.receiving)[order.edge] = sock

    def for_plan(self, plan: Plan) -> EdgeLinks:
        """Links that make the ends of the edges that come with a new plan."""
        new = EdgeLinks(plan, {}, {}, self.session, self.run, self.incarnation)
        new.sending, new.receiving, new._working = self.sending, self.receiving, self.plan
        return new

    def adopt(self, new: EdgeLinks) -> None:
        """Take over the plan and the ends of the links made for it, and drop edges that the plan lacks."""
        stay = {number for number, _ in new.plan.numbered()}
        for edge in self._ring_readers.keys() - stay:
            self._refused[self.plan.edge(edge).name] += self._ring_readers.pop(edge)[0].rejected
        for edge in self._ring_writers.keys() - stay:
            del self._ring_writers[edge]
        self._zenoh_ends += new._zenoh_ends
        self.plan = self._working = new.plan
        self._ring_readers |= new._ring_readers
        self._ring_writers |= new._ring_writers

    def forget(self) -> None:
        """See `Links.forget`."""
        known = {number for number, _ in self._working.numbered()}
        for ends in (self.sending, self.receiving):
            for edge in ends.keys() - known:
                ends.pop(edge).close()
        for _, end in self._zenoh_ends:
            end.close()
        self._zenoh_ends = []

    def renew(self, scheduler: Scheduler, edge: int, sock: socket.socket) -> None:
        """Connect a ring edge through `sock`: the worker at the other end was started again."""
        if edge in self._ring_readers:
            old, kind = self._ring_readers[edge]
            self._refused[self.plan.edge(edge).name] += old.rejected
            scheduler.ends.adopt_reader(old, self._ring_reader(edge, sock, kind))
        else:
            ring, index = self._ring_writers[edge]
            ring.replace(index, sock)
            scheduler.ends.adopt_link(ring, sock.fileno())

    def _ring_reader(self, edge: int, sock: socket.socket, kind: type[Message]) -> RingReader:
        reader = RingReader(sock, kind, partial(self._fellow, edge))
        self._ring_readers[edge] = reader, kind
        return reader

    def _homes(self, edges: Sequence[int]) -> list[Home]:
        """Where the readers of edges are, so that readers in one worker share datagrams; [] if none share.

        A worker that was started again gets its edges one by one, so their readers do not share.
        """
        if self.incarnation:
            return []
        return [Home(self.plan.worker_of(self.plan.edge(edge).to_stage), edge) for edge in edges]

    def _fellow(self, edge: int, other: int) -> RingReader | None:
        """The reader here of another edge from the same port; None if there is none."""
        if other not in self._ring_readers:
            return None
        mine, theirs = self.plan.edge(edge), self.plan.edge(other)
        same = (mine.from_stage, mine.from_port) == (theirs.from_stage, theirs.from_port)
        return self._ring_readers[other][0] if same else None

    def wait_matched(self, wanted: Callable[[], bool] = lambda: True) -> None:
        """Block until every Zenoh edge has found its other end, so that nothing is lost at the start.

        wanted: asked again and again; the wait ends when it returns False. Raises FollowspotError naming the
        edges that did not.
        """
        deadline = time.monotonic() + _MATCH_TIMEOUT
        waiting = self._zenoh_ends
        while waiting and wanted():
            waiting = [(name, end) for name, end in waiting if not end.matched()]
            if waiting and time.monotonic() > deadline:
                names = ", ".join(sorted({name for name, _ in waiting}))
                raise FollowspotError(f"Zenoh found no other end for {names} within {_MATCH_TIMEOUT:.0f} s")
            if waiting:
                time.sleep(0.005)

    def remind(self) -> None:
        """Announce the ends of Zenoh edges again: other workers that wait for them may have missed it."""
        for _, end in self._zenoh_ends:
            end.matched()

    def rejected(self) -> dict[str, int]:
        """For each edge that got anything malformed or not from its other end: how much."""
        found = self._refused.copy()
        for name, end in self._zenoh_ends:
            found[name] += end.rejected
        for edge, (reader, _) in self._ring_readers.items():
            found[self.plan.edge(edge).name] += reader.rejected
        for edge, (writer, index) in self._ring_writers.items():
            found[self.plan.edge(edge).name] += 0 if index else writer.rejected
        return {name: count for name, count in found.items() if count}

    def close(self) -> None:
        """Close the session; the edges were closed by their worker."""
        if self.session is not None:
            from followspot.transport.zenoh.session import close_session

            close_session(self.session)
            self.session = None

    def _depth(self, edges: Sequence[PlannedEdge]) -> int:
        """Most messages on their way to the slowest reader."""
        return AHEAD if edges[0].drops and self.plan.live else max(edge.capacity for edge in edges)

    def _key(self, edge: int) -> str:
        """Key of the edge's port, or one of its own if it carries other messages than the first edges.

        An edge that drops carries fewer, and one that came while the run went on begins later.
        """
        planned = self.plan.edge(edge)
        host = self.plan.host_of_stage(planned.from_stage)
        port = port_key(self.run, host, planned.from_stage, planned.from_port)
        if planned.drops:
            return f"{port}/{planned.policy}/{edge}"
        addition = self.plan.addition(edge)
        return f"{port}/added/{addition}" if addition else port


def uses_zenoh(plan: Plan, worker: str | None = None) -> bool:
    """Whether any edge of the plan, or of this worker, goes over Zenoh."""
    return any(
        edge.kind == "zenoh"
        and (worker is None or worker in map(plan.worker_of, (edge.from_stage, edge.to_stage)))
        for edge in plan.edges
    )


def rows_of(plan: Plan, workers: Collection[str]) -> set[int]:
    """Ledger rows of the edges to and from these workers."""
    theirs = {stage.name for stage in plan.stages if stage.worker in workers}
    return {n * COLUMNS for n, e in plan.numbered() if e.from_stage in theirs or e.to_stage in theirs}


def ring_edges(plan: Plan) -> list[int]:
    """Numbers of the edges that need a socket pair."""
    return [number for number, edge in plan.numbered() if edge.kind == "ring"]


def socket_pair() -> tuple[socket.socket, socket.socket]:
    """Sending and receiving end of one ring edge; they have no name, so a kill leaves nothing behind."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)

"""Makes the ends of a worker's edges to other workers: rings over socket pairs, and edges over Zenoh."""

from __future__ import annotations

import socket
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from followspot.control.worker_orders import TakeRing
from followspot.graph.depths import MAX_IN_TRANSIT
from followspot.graph.plan import EdgeKind, Plan, PlannedEdge
from followspot.messages import Message
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.ring.links import ReaderLocation
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.worker.scheduler import Scheduler
from followspot.worker.zenoh_edge_factory import ZenohEdgeFactory

if TYPE_CHECKING:
    import zenoh


class WorkerEdgeFactory:
    """Makes the ends of a worker's edges.

    sending, receiving: this worker's ends of the ring edges' socket pairs, by edge number; session, run,
    incarnation: see `ZenohEdgeFactory`.
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
        """The plan for whose edges this makes ends. `_working`: the plan of the edges in use."""
        self.sending = dict(sending)
        self.receiving = dict(receiving)
        self.zenoh = ZenohEdgeFactory(session, run, incarnation)
        self._ring_readers: dict[int, tuple[RingReader, type[Message]]] = {}
        self._ring_writers: dict[int, tuple[RingWriter | DroppingWriter, int]] = {}
        self._refused: Counter[str] = Counter()
        """Refusals of ends that were replaced since, by edge."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """The reading end of one edge."""
        planned = self.plan.edge(edge)
        if planned.kind == "ring":
            return self._ring_reader(edge, self.receiving[edge], kind)
        return self.zenoh.reader(self.plan, edge, kind, self._depth([planned]))

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """The writing end of all edges of one output port that have the same kind, codec and policy."""
        planned = [self.plan.edge(edge) for edge in edges]
        drops = planned[0].drops and self.plan.live
        if kind == "ring":
            ring: RingWriter | DroppingWriter = RingWriter(
                [self.sending[edge] for edge in edges], self._depth(planned), self._locations(edges)
            )
            ring = DroppingWriter(ring, planned[0].depth) if drops else ring
            self._ring_writers.update({edge: (ring, index) for index, edge in enumerate(edges)})
            return ring
        writer = self.zenoh.writer(self.plan, edges, self._depth(planned))
        return DroppingWriter(writer, planned[0].depth) if drops else writer

    def take(self, scheduler: Scheduler, order: TakeRing, sock: socket.socket) -> None:
        """Take one end of a ring: of an edge that works already, or of one that the graph is to get."""
        if order.edge in self._ring_readers or order.edge in self._ring_writers:
            self.renew(scheduler, order.edge, sock)
        else:
            (self.sending if order.side == "sending" else self.receiving)[order.edge] = sock

    def for_plan(self, plan: Plan) -> WorkerEdgeFactory:
        """A factory for the ends of the edges that come with a new plan."""
        new = WorkerEdgeFactory(plan, {}, {}, self.zenoh.session, self.zenoh.run, self.zenoh.incarnation)
        new.sending, new.receiving, new._working = self.sending, self.receiving, self.plan
        return new

    def adopt(self, new: WorkerEdgeFactory) -> None:
        """Take over the plan and the ends of its factory, and drop edges that the plan lacks."""
        stay = {number for number, _ in new.plan.numbered()}
        for edge in self._ring_readers.keys() - stay:
            self._refused[self.plan.edge(edge).name] += self._ring_readers.pop(edge)[0].rejected
        for edge in self._ring_writers.keys() - stay:
            del self._ring_writers[edge]
        self.zenoh.adopt(new.zenoh)
        self.plan = self._working = new.plan
        self._ring_readers |= new._ring_readers
        self._ring_writers |= new._ring_writers

    def forget(self) -> None:
        """See `EdgeFactory.forget`."""
        known = {number for number, _ in self._working.numbered()}
        for ends in (self.sending, self.receiving):
            for edge in ends.keys() - known:
                ends.pop(edge).close()
        self.zenoh.forget()

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
        reader = RingReader(sock, kind, partial(self._reader_beside, edge))
        self._ring_readers[edge] = reader, kind
        return reader

    def _locations(self, edges: Sequence[int]) -> list[ReaderLocation]:
        """The workers of the readers of edges, so that those in one worker share datagrams; [] if none share.

        A worker that was started again gets its edges one by one, so their readers do not share.
        """
        if self.zenoh.incarnation:
            return []
        return [ReaderLocation(self.plan.worker_of(self.plan.edge(edge).to_stage), edge) for edge in edges]

    def _reader_beside(self, edge: int, other: int) -> RingReader | None:
        """The reader here of another edge from the same port; None if there is none."""
        if other not in self._ring_readers:
            return None
        mine, theirs = self.plan.edge(edge), self.plan.edge(other)
        same = (mine.from_stage, mine.from_port) == (theirs.from_stage, theirs.from_port)
        return self._ring_readers[other][0] if same else None

    def wait_matched(self, wanted: Callable[[], bool] = lambda: True) -> None:
        """See `ZenohEdgeFactory.wait_matched`; both ends of a ring are there from the start."""
        self.zenoh.wait_matched(wanted)

    def rejected(self) -> dict[str, int]:
        """For each edge that got anything malformed or not from its other end: how much.

        Safe from any thread.
        """
        found = self._refused.copy()
        for name, count in self.zenoh.rejected():
            found[name] += count
        for edge, (reader, _) in tuple(self._ring_readers.items()):
            found[self.plan.edge(edge).name] += reader.rejected
        for edge, (writer, index) in tuple(self._ring_writers.items()):
            found[self.plan.edge(edge).name] += 0 if index else writer.rejected
        return {name: count for name, count in found.items() if count}

    def _depth(self, edges: Sequence[PlannedEdge]) -> int:
        """Most messages on their way to the slowest reader."""
        return MAX_IN_TRANSIT if edges[0].drops and self.plan.live else max(edge.capacity for edge in edges)

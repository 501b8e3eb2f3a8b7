"""The socket pairs of a host's ring edges, and the worker that gets each end.

A socket pair has no name: a kill leaves nothing behind, and no other process can connect.
"""

from __future__ import annotations

import socket
from collections.abc import Collection, Iterator
from typing import NamedTuple

from followspot.control.worker_orders import Side
from followspot.graph.plan import Plan
from followspot.transport.ring.link import socket_pair


class RingEnd(NamedTuple):
    """One end of a ring edge; the worker that takes it must close it.

    edge: its number in the plan; worker: gets the end; of: the worker for whose restart the pair was made,
    "" for the first pairs.
    """

    edge: int
    side: Side
    worker: str
    of: str
    socket: socket.socket


class Rings:
    """The ends of rings that no worker has taken yet."""

    def __init__(self, plan: Plan, workers: set[str]) -> None:
        """workers: of this host; a ring connects two of them."""
        self._waiting: list[RingEnd] = []
        self.rearrange(plan, workers)
        for edge in self._homes:
            self._pair(edge, "")

    def rearrange(self, plan: Plan, workers: set[str]) -> None:
        """Take a new plan; new edges get their ends when one of their workers restarts."""
        rings = ((number, plan.edge(number)) for number in plan.ring_edges())
        ends = {n: (plan.worker_of(edge.from_stage), plan.worker_of(edge.to_stage)) for n, edge in rings}
        self._homes = {edge: pair for edge, pair in ends.items() if pair[0] in workers}

    def added(self, plan: Plan, workers: set[str]) -> Iterator[RingEnd]:
        """New ends for the edges that a plan adds between workers here that run already."""
        for number in plan.ring_edges():
            edge = plan.edge(number)
            sender, receiver = plan.worker_of(edge.from_stage), plan.worker_of(edge.to_stage)
            if number not in self._homes and sender in workers:
                sending, receiving = socket_pair()
                yield RingEnd(number, "sending", sender, "", sending)
                yield RingEnd(number, "receiving", receiver, "", receiving)

    def take(self, worker: str) -> list[RingEnd]:
        """Remove and return the ends that a worker starts with: of first pairs, or of pairs made for it."""
        return self._remove([e for e in self._waiting if e.worker == worker and e.of in ("", worker)])

    def discard(self, worker: str) -> None:
        """Close the ends of a worker that will not start, so that its peers do not wait for it."""
        for end in self.take(worker):
            end.socket.close()

    def renew(self, worker: str) -> None:
        """Make new pairs for all edges of a worker that restarts; close the unused ends of the old ones."""
        mine = [edge for edge, homes in self._homes.items() if worker in homes]
        for end in self._remove([end for end in self._waiting if end.edge in mine]):
            end.socket.close()
        for edge in mine:
            self._pair(edge, worker)

    def join(self, worker: str, running: Collection[str]) -> list[RingEnd]:
        """The ends to hand out now that a restarted worker is ready.

        Running peers get the other ends of the pairs that it started with. If a peer has restarted since,
        that pair is broken, so both get ends of a new pair. A peer that is not running gets its ends when it
        restarts.
        """
        ends = []
        for edge, homes in self._homes.items():
            if worker not in homes or homes[0] == homes[1]:
                continue
            other = homes[0] if homes[1] == worker else homes[1]
            theirs = self._remove(
                [e for e in self._waiting if (e.edge, e.worker, e.of) == (edge, other, worker)]
            )
            if other in running and not theirs:
                self._pair(edge, worker)
                theirs = self._remove([e for e in self._waiting if (e.edge, e.of) == (edge, worker)])
            if other in running:
                ends += theirs
            else:
                for end in theirs:
                    end.socket.close()
        return ends

    def close(self) -> None:
        """Close the ends that no worker has taken."""
        for end in self._waiting:
            end.socket.close()
        self._waiting = []

    def _remove(self, ends: list[RingEnd]) -> list[RingEnd]:
        """Remove and return these ends."""
        self._waiting = [end for end in self._waiting if end not in ends]
        return ends

    def _pair(self, edge: int, of: str) -> None:
        sender, receiver = self._homes[edge]
        sending, receiving = socket_pair()
        self._waiting.append(RingEnd(edge, "sending", sender, of, sending))
        self._waiting.append(RingEnd(edge, "receiving", receiver, of, receiving))

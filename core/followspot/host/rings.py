"""The socket pairs under a host's ring edges, and which worker each end goes to.

A pair has no name: nothing is left behind by a kill, and nobody else can take part.
"""

from __future__ import annotations

import socket
from collections.abc import Collection
from typing import NamedTuple

from followspot.control.worker_orders import Side
from followspot.graph.plan import Plan
from followspot.worker.edge_links import ring_edges, socket_pair


class RingEnd(NamedTuple):
    """One end of a ring edge, which belongs to whoever takes it.

    edge: its number in the plan; worker: to have it; of: the worker whose start made the pair, "" at first.
    """

    edge: int
    side: Side
    worker: str
    of: str
    socket: socket.socket


class Rings:
    """Ends that wait for their workers."""

    def __init__(self, plan: Plan, workers: set[str]) -> None:
        """workers: of this host; rings lead from one of them to another."""
        self._waiting: list[RingEnd] = []
        self.rearrange(plan, workers)
        for edge in self._homes:
            self._pair(edge, "")

    def rearrange(self, plan: Plan, workers: set[str]) -> None:
        """The plan is another one now; new edges get their ends when a worker of theirs starts again."""
        rings = ((number, plan.edges[number]) for number in ring_edges(plan))
        ends = {n: (plan.worker_of(edge.from_stage), plan.worker_of(edge.to_stage)) for n, edge in rings}
        self._homes = {edge: pair for edge, pair in ends.items() if pair[0] in workers}

    def take(self, worker: str) -> list[RingEnd]:
        """The ends that a worker starts with: those of the first pairs, or of the pairs made for it."""
        return self._taken([e for e in self._waiting if e.worker == worker and e.of in ("", worker)])

    def give_up(self, worker: str) -> None:
        """A worker that will not start: close the ends that wait for it, so that others need not wait."""
        for end in self.take(worker):
            end.socket.close()

    def renew(self, worker: str) -> None:
        """New pairs for all edges of a worker that starts again; what was left of the last ones is closed."""
        mine = [edge for edge, homes in self._homes.items() if worker in homes]
        for end in self._taken([end for end in self._waiting if end.edge in mine]):
            end.socket.close()
        for edge in mine:
            self._pair(edge, worker)

    def join(self, worker: str, running: Collection[str]) -> list[RingEnd]:
        """A worker that was started again is ready: the ends to hand out, and not before.

        Those at work get the other ends of what it started with. Where one of them has started again since,
        that pair is broken, so both get ends of a new one; who is not at work will bring its own.
        """
        ends = []
        for edge, homes in self._homes.items():
            if worker not in homes or homes[0] == homes[1]:
                continue
            other = homes[0] if homes[1] == worker else homes[1]
            theirs = self._taken(
                [e for e in self._waiting if (e.edge, e.worker, e.of) == (edge, other, worker)]
            )
            if other in running and not theirs:
                self._pair(edge, worker)
                theirs = self._taken([e for e in self._waiting if (e.edge, e.of) == (edge, worker)])
            if other in running:
                ends += theirs
            else:
                for end in theirs:
                    end.socket.close()
        return ends

    def close(self) -> None:
        """Close the ends that nobody took."""
        for end in self._waiting:
            end.socket.close()
        self._waiting = []

    def _taken(self, ends: list[RingEnd]) -> list[RingEnd]:
        """These ends, which wait no more."""
        self._waiting = [end for end in self._waiting if end not in ends]
        return ends

    def _pair(self, edge: int, of: str) -> None:
        sender, receiver = self._homes[edge]
        sending, receiving = socket_pair()
        self._waiting.append(RingEnd(edge, "sending", sender, of, sending))
        self._waiting.append(RingEnd(edge, "receiving", receiver, of, receiving))

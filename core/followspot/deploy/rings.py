"""The socket pairs under a host's ring edges, and which worker each end goes to.

A pair has no name: nothing is left behind by a kill, and nobody else can take part.
"""

from __future__ import annotations

import socket
from typing import Literal, NamedTuple

from followspot.deploy.links import ring_edges, socket_pair
from followspot.graph.plan import Plan

Side = Literal["sending", "receiving"]


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
        home = {stage.name: stage.worker for stage in plan.stages}
        ends = {n: (home[plan.edges[n].from_stage], home[plan.edges[n].to_stage]) for n in ring_edges(plan)}
        self._homes = {edge: pair for edge, pair in ends.items() if pair[0] in workers}
        self._waiting: list[RingEnd] = []
        for edge in self._homes:
            self._pair(edge, "")

    def take(self, worker: str | None = None, *, of: str) -> list[RingEnd]:
        """The ends that wait for a worker: those of the first pairs, and of the pairs made for `of`.

        Of all workers where none is named, but then of the pairs made for `of` alone: when a worker is ready
        that was started again, and not before, the others get theirs, for nobody would read what they send.
        """
        origins = (of,) if worker is None else ("", of)
        taken = [e for e in self._waiting if e.of in origins and worker in (None, e.worker)]
        self._waiting = [end for end in self._waiting if end not in taken]
        return taken

    def renew(self, worker: str) -> None:
        """New pairs for all edges of a worker that starts again; what was left of its last ones is closed."""
        for end in [end for end in self._waiting if end.worker == worker or end.of == worker]:
            end.socket.close()
            self._waiting.remove(end)
        for edge, homes in self._homes.items():
            if worker in homes:
                self._pair(edge, worker)

    def close(self) -> None:
        """Close the ends that nobody took."""
        for end in self._waiting:
            end.socket.close()
        self._waiting = []

    def _pair(self, edge: int, of: str) -> None:
        sender, receiver = self._homes[edge]
        sending, receiving = socket_pair()
        self._waiting.append(RingEnd(edge, "sending", sender, of, sending))
        self._waiting.append(RingEnd(edge, "receiving", receiver, of, receiving))

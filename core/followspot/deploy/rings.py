"""The socket pairs under a host's ring edges, and which worker each end goes to.

A pair has no name: nothing is left behind by a kill, and nobody else can take part.
"""

from __future__ import annotations

import socket
from collections.abc import Iterator
from typing import Literal, NamedTuple

from followspot.deploy.links import ring_edges, socket_pair
from followspot.graph.plan import Plan

Side = Literal["sending", "receiving"]


class RingEnd(NamedTuple):
    """One end of a ring edge; edge: its number in the plan; it belongs to whoever takes it."""

    edge: int
    side: Side
    worker: str
    socket: socket.socket


class Rings:
    """Ends that wait for their workers to start."""

    def __init__(self, plan: Plan, workers: set[str]) -> None:
        """workers: of this host; rings lead from one of them to another."""
        home = {stage.name: stage.worker for stage in plan.stages}
        ends = {n: (home[plan.edges[n].from_stage], home[plan.edges[n].to_stage]) for n in ring_edges(plan)}
        self._homes = {edge: pair for edge, pair in ends.items() if pair[0] in workers}
        self._waiting = [end for edge in self._homes for end in self._pair(edge)]

    def take(self, worker: str) -> list[RingEnd]:
        """The ends that wait for a worker's first start."""
        taken = [end for end in self._waiting if end.worker == worker]
        self._waiting = [end for end in self._waiting if end.worker != worker]
        return taken

    def renew(self, worker: str) -> list[RingEnd]:
        """New pairs for all edges of a worker that starts again: both its ends and those of the others."""
        self.take(worker)
        return [end for edge, homes in self._homes.items() if worker in homes for end in self._pair(edge)]

    def close(self) -> None:
        """Close the ends that nobody took."""
        for end in self._waiting:
            end.socket.close()
        self._waiting = []

    def _pair(self, edge: int) -> Iterator[RingEnd]:
        sender, receiver = self._homes[edge]
        sending, receiving = socket_pair()
        yield RingEnd(edge, "sending", sender, sending)
        yield RingEnd(edge, "receiving", receiver, receiving)

"""The interface that makes the ends of a worker's edges to other workers.

`followspot.worker.worker_edge_factory` implements it with rings and Zenoh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from followspot.graph.plan import EdgeKind
from followspot.messages import Message
from followspot.transport.edge import PortReader, PortWriter


class EdgeFactory(Protocol):
    """Makes the ends of edges between workers. An edge is given by its number in the plan."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """The reading end of one edge."""

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """The writing end of all edges of one output port that have the same kind and codec."""

    def wait_matched(self, wanted: Callable[[], bool]) -> None:
        """Block until the other ends are there, or until `wanted` returns False. Raises FollowspotError."""

    def forget(self) -> None:
        """Close the new ends: the graph does not get their edges after all."""


class NoEdgeFactory:
    """The factory of a plan whose edges all stay within one worker."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """Raises LookupError."""
        raise LookupError(f"edge {edge} ({kind.__name__}) leads to no other worker")

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """Raises LookupError."""
        raise LookupError(f"edges {edges} ({kind}) lead to no other worker")

    def wait_matched(self, wanted: Callable[[], bool]) -> None:
        """Do nothing: there are no ends."""

    def forget(self) -> None:
        """Do nothing: there are no ends."""

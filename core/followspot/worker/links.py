"""What makes the ends of a worker's edges; `edge_links.EdgeLinks` does it with rings and Zenoh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from followspot.graph.plan import EdgeKind
from followspot.messages import Message
from followspot.transport.edge import PortReader, PortWriter


class Links(Protocol):
    """Makes the ends of edges between workers; edges are named by their number in the plan."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """The reading end of one edge."""

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """The writing end of all edges of one output port that have the same kind and codec."""

    def wait_matched(self, wanted: Callable[[], bool]) -> None:
        """Block until the ends have found their other ends, or are not `wanted`. Raises FollowspotError."""

    def forget(self) -> None:
        """Close the ends for edges that the graph does not get after all."""


class NoLinks:
    """Links of a plan whose edges all stay within one worker."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """Raises LookupError."""
        raise LookupError(f"edge {edge} ({kind.__name__}) has no link")

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """Raises LookupError."""
        raise LookupError(f"edges {edges} ({kind}) have no link")

    def wait_matched(self, wanted: Callable[[], bool]) -> None:
        """Do nothing: there are no ends."""

    def forget(self) -> None:
        """Do nothing: there are no ends."""

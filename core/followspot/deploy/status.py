"""A run at one moment, for those who look on: the page, `followspot top`, metrics."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from followspot.deploy.host import WorkerStatus
from followspot.graph.plan import Plan, PlannedEdge
from followspot.runtime.ledger import COLUMNS, EdgeCount, tally


@dataclass(frozen=True)
class RunStatus:
    """counts: words of the ledger, of all edges of the plan; fired, expected: frames done and to be done."""

    workers: tuple[WorkerStatus, ...]
    counts: tuple[int, ...]
    fired: int
    expected: int | None
    news: tuple[str, ...] = ()

    def edges(self, plan: Plan) -> Iterator[tuple[PlannedEdge, EdgeCount]]:
        """Each edge with its counts."""
        for number, edge in enumerate(plan.edges):
            row = self.counts[number * COLUMNS : (number + 1) * COLUMNS]
            if row:  # a host that has not answered yet has none
                yield edge, tally(row)


OnStatus = Callable[[RunStatus], None]
"""Called a few times a second."""

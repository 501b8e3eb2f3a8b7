"""A run at one moment, for those who look on: the operator's page, `followspot top`, metrics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import pydantic

from followspot.deploy.clocks.status import ClockStatus
from followspot.deploy.host import WorkerStatus
from followspot.graph.plan import Plan, PlannedEdge
from followspot.runtime.ledger import COLUMNS, EdgeCount, tally


@dataclass(frozen=True)
class RunStatus:
    """One moment.

    counts: words of the ledger, of all edges of the plan; fired, expected: frames done and to be done;
    clocks: of the hosts that go by that of another one, "" for the operator's own.
    """

    workers: tuple[WorkerStatus, ...]
    counts: tuple[int, ...]
    fired: int
    expected: int | None
    news: tuple[str, ...] = ()
    clocks: Mapping[str, ClockStatus] = field(default_factory=dict)

    def edges(self, plan: Plan) -> Iterator[tuple[PlannedEdge, EdgeCount]]:
        """Each edge with its counts."""
        for number, edge in enumerate(plan.edges):
            row = self.counts[number * COLUMNS : (number + 1) * COLUMNS]
            if row:  # a host that has not answered yet has none
                yield edge, tally(row)

    def to_data(self) -> Any:
        """JSON types; without the reports of workers that have ended."""
        return _STATUS.dump_python(self, mode="json", exclude={"workers": {"__all__": {"report"}}})


def run_status_from_data(data: Any) -> RunStatus:
    """A status that came from elsewhere. Raises ValueError."""
    return _STATUS.validate_python(data)


_STATUS: pydantic.TypeAdapter[RunStatus] = pydantic.TypeAdapter(RunStatus)

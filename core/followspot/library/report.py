"""The report of a run, for people and for programs."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

from followspot.library.table import Table
from followspot.operator.reporting import summary
from followspot.operator.reporting.report import RunReport
from followspot.operator.reporting.silence import Silence
from followspot.scoring import Score
from followspot.worker.ledger import COUNTS, SOURCE_LOSSES


class Report:
    """Report of a run that has ended: ledger, latency and accuracy as tables, warnings and errors.

    out: the folder of its outputs; scores: of targets or persons, if the room has ground truth.
    """

    def __init__(self, run: RunReport, out: Path, scores: Mapping[str, Score]) -> None:
        self.run = run
        self.out = out
        self.scores = dict(scores)

    @property
    def frames(self) -> int:
        """Messages that the busiest source sent."""
        return self.run.frames

    @property
    def seconds(self) -> float:
        """From the start of all workers to the end of the last."""
        return self.run.seconds

    @property
    def stopped(self) -> bool:
        """True if the run was stopped before its sources ended."""
        return self.run.stopped

    @property
    def ok(self) -> bool:
        """True if the run succeeded, and every message is accounted for."""
        return self.run.ok

    @property
    def errors(self) -> tuple[str, ...]:
        """Errors of the run; empty if it succeeded."""
        return (*self.run.errors, *self.run.unbalanced)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of all workers, and faults from which the run recovered."""
        return self.run.warnings

    @property
    def silences(self) -> tuple[Silence, ...]:
        """Ports that never gave a message with rows, although all that feeds their stage did."""
        return self.run.silences

    @cached_property
    def ledger(self) -> Table:
        """Counts of the messages of each edge, by their fate: the columns of the ledger."""
        rows = [
            (
                f"{edge.from_stage}.{edge.from_port}",
                f"{edge.to_stage}.{edge.to_port}",
                edge.kind,
                *(getattr(count, name) for name in (*COUNTS, *SOURCE_LOSSES)),
            )
            for edge, count in self.run.edges
        ]
        return Table(("from", "to", "kind", *COUNTS, *SOURCE_LOSSES), rows)

    @cached_property
    def latency(self) -> Table:
        """From each source to each sink, ms; worst_id: the message that took longest."""
        paths = [path for worker in self.run.workers for path in worker.paths]
        rows = [(p.origin, p.sink, p.count, p.p50_ms, p.p95_ms, p.worst_ms, p.worst_id) for p in paths]
        return Table(("from", "to", "count", "p50_ms", "p95_ms", "worst_ms", "worst_id"), rows)

    @cached_property
    def accuracy(self) -> Table:
        """A row for each target or person; empty if the room has no ground truth."""
        for score in self.scores.values():
            found = score.to_data()
            columns = list(next(iter(found.values()), {}))
            rows = [(name, *(row.get(column) for column in columns)) for name, row in found.items()]
            return Table((score.noun, *columns), rows)
        return Table(("target",), [])

    def to_json(self) -> dict[str, Any]:
        """The whole report in JSON types, as ``followspot run --json`` prints it."""
        return summary.data(self.run, {name: score.to_data() for name, score in self.scores.items()})

    def __repr__(self) -> str:
        return summary.text(self.run, "\n\n".join(map(str, self.scores.values())))

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"

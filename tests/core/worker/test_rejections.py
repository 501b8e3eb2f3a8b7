"""A worker tells of each edge once that it refuses something, and at the end how often it did."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, cast

import pytest

from followspot.log.collector import LogCollector
from followspot.worker.reporting.rejections import Rejections
from followspot.worker.reporting.report import Warnings
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

RING, ZENOH = "a.out -> b.number", "b.out -> save.number"
REFUSED = "what was malformed or not from its sender"


@dataclass
class Links:
    """What edges of two kinds have refused so far."""

    counts: dict[str, int] = field(default_factory=dict)
    plan: Any = field(
        default_factory=lambda: SimpleNamespace(
            edges=(SimpleNamespace(name=RING, kind="ring"), SimpleNamespace(name=ZENOH, kind="zenoh"))
        )
    )

    def rejected(self) -> dict[str, int]:
        return dict(self.counts)


@pytest.mark.parametrize(
    ("certified", "source"),
    [
        (False, "any program that reaches this run can send that, unless hosts have certificates"),
        (True, "a host with a certificate sent that"),
    ],
)
def test_refusals_are_told_at_once_and_summed_up_at_the_end(certified: bool, source: str) -> None:
    links, log, warnings = Links(), LogCollector("w"), Warnings()
    rejections = Rejections(cast("WorkerEdgeFactory", links), log, certified=certified)
    rejections.tell_new()
    assert log.take() == []
    links.counts = {RING: 1, ZENOH: 2}
    rejections.tell_new()
    links.counts = {RING: 1, ZENOH: 7}
    rejections.tell_new()
    ring, zenoh = log.take()
    assert (ring.stage, ring.text) == (RING, f"refuses {REFUSED}")
    assert (zenoh.level, zenoh.stage) == ("warning", ZENOH)
    assert zenoh.text.startswith(f"refuses {REFUSED}; {source}")
    rejections.warn(warnings)
    ring_line, zenoh_line = warnings.lines()
    assert ring_line == f"{RING}: refused 1 times {REFUSED}"
    assert zenoh_line.startswith(f"{ZENOH}: refused 7 times {REFUSED}; {source}")

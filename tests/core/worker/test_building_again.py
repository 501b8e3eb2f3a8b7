"""A worker that is built again goes on with the counts of the one that died."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.compile import compile_graph
from followspot.worker.build import build_worker
from followspot.worker.ledger import DELIVERED, PRODUCED, Ledger
from followspot.worker.wiring import RunOptions, Wiring

TICKS = str(Path(__file__).parents[2] / "stages" / "ticks.py")


def test_what_was_under_way_within_a_worker_that_died_is_lost(tmp_path: Path) -> None:
    (tmp_path / "graph.yaml").write_text(
        "graph: g\nstages:\n  a: {uses: ticks.count}\n  save: {uses: ticks.write, in: {number: a}}\n"
    )
    plan = compile_graph(tmp_path / "graph.yaml", plugin_files=[TICKS])
    ledger = Ledger(1)
    ledger.words[PRODUCED], ledger.words[DELIVERED] = 7, 4
    for _ in range(2):  # the second one finds nothing more
        scheduler = build_worker(Wiring(plan), "main", ledger, RunOptions(tmp_path))
        scheduler.close()
        count = ledger.count(0)
        assert (count.sent, count.delivered, count.lost, count.in_flight) == (7, 4, 3, 0)

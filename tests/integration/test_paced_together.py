"""Sources that play at a pace count from one moment, in whichever workers they are."""

from __future__ import annotations

import time
from pathlib import Path

from tests.integration.running import run, write_graph

from followspot.context import Context

PACED = Path(__file__).parents[1] / "stages" / "paced.py"
GRAPH = """
one:  {uses: paced.begun}
two:  {uses: paced.begun}
both: {uses: paced.together, in: {left: one, right: two}}
"""


def test_sources_of_two_workers_count_from_one_moment(tmp_path: Path) -> None:
    graph = write_graph(tmp_path, GRAPH)
    finished = run(graph, "--plugin", str(PACED), "--placement", "stage")
    assert finished.code == 0, finished.errors
    assert finished.edge("one.", "both.")["delivered"] == 1


def test_a_stage_that_comes_later_counts_from_when_it_comes() -> None:
    began = time.monotonic_ns()
    assert Context(run_begun=lambda: 7).begun() == 7
    assert Context(run_begun=lambda: 7, resumed=True).begun() >= began

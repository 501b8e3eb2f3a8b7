"""The loop over a port may itself change the run, although the run waits for the loop."""

from __future__ import annotations

from pathlib import Path

from tests.integration.running import wait_until

import followspot as fs

SETS = Path(__file__).parents[2] / "stages" / "sets.py"
GRAPH = """
graph: loop
stages:
  a: {uses: sets.count}
  b: {uses: sets.pass, in: {note: a}}
"""


def test_a_loop_that_holds_up_the_run_changes_it_and_misses_nothing(tmp_path: Path) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text(GRAPH)
    with fs.run(graph, plugin_files=[SETS], ports=["a"], out=tmp_path / "out") as run:
        notes = run["a"]
        assert wait_until(lambda: "64 waiting" in repr(notes))
        assert run.set("b.label", 5).stages[0].params == {"label": 5}
        assert [next(notes).number for _ in range(100)] == list(range(100))
        assert notes.dropped == 0

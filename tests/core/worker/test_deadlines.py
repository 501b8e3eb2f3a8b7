"""How long live joins wait for what is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.graph.compile import compile_graph
from followspot.plugins.registry import use_plugin_files
from followspot.worker.wiring import Wiring

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
JOINS = """
graph: g
stages:
  a:    {uses: ticks.live}
  b:    {uses: ticks.live}
  sum:  {uses: ticks.sum, in: {numbers: [a, b]}, deadline: 0.1}
  more: {uses: ticks.add, in: {number: sum}}
  all:  {uses: ticks.sum, in: {numbers: [more, a]}, deadline: 0.05}
"""


def test_a_join_waits_for_what_a_join_upstream_makes_without_those_missing(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(JOINS)
    use_plugin_files([str(TICKS)])
    wiring = Wiring(compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS]))
    assert wiring.deadline["sum"] == 0.1
    assert wiring.deadline["all"] == pytest.approx(0.15), "b is given up by then, and the sum is on its way"

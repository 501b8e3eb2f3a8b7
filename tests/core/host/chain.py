"""The plan of a chain of three stages, each in a worker of its own."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
CHAIN = """
graph: g
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.add, in: {number: a}}
  c: {uses: ticks.write, in: {number: b}}
"""


def chain_plan(folder: Path) -> Plan:
    """The plan of a, b and c; its graph file is in the folder."""
    (folder / "g.yaml").write_text(CHAIN)
    return compile_graph(folder / "g.yaml", placement="stage", plugin_files=[TICKS])

"""A graph of two stages, and its plan after a change of their edge."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from followspot.graph.plan import Plan

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
PAIR = """
graph: g
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.write, in: {number: a}}
"""


def with_another_edge(plan: Plan) -> Plan:
    """The plan after a change that puts another edge between the same ports in the place of the first."""
    (edge,) = plan.edges
    return replace(plan, numbers=(1,), former=((0, edge),), additions=(1,))

"""Stages that go to another place of a plan: edges of other kinds, and the workers that must begin anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.errors import InputError
from followspot.graph.change.move import plan_after_move, restarted_workers
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a: {uses: ticks.SOURCE}
  b: {uses: ticks.add, in: {number: a}}
  c: {uses: ticks.add, in: {number: b}}
  d: {uses: ticks.write, in: {number: c}}
"""
PLACEMENT = """
placement: p
workers:
  one:   {host: pc-left, stages: [a]}
  two:   {host: pc-left, stages: [b]}
  three: {host: pc-right, stages: [c]}
  four:  {stages: [d]}
"""


def planned(folder: Path, source: str = "live") -> Plan:
    (folder / "g.yaml").write_text(GRAPH.replace("SOURCE", source))
    (folder / "p.yaml").write_text(PLACEMENT)
    return compile_graph(folder / "g.yaml", placement=folder / "p.yaml", plugin_files=[TICKS])


def kinds(plan: Plan) -> list[str]:
    return [edge.kind for edge in plan.edges]


@pytest.mark.parametrize(
    ("stage", "place", "after", "begin"),
    [
        ("b", "one", ["reference", "zenoh", "zenoh"], {"one", "two"}),
        ("a", "pc-right", ["zenoh", "zenoh", "zenoh"], {"one", "two", "three"}),
        ("c", "pc-left", ["ring", "ring", "zenoh"], {"one", "two", "three", "four"}),
        ("d", "three", ["ring", "zenoh", "reference"], {"three", "four"}),
        ("d", "one", ["ring", "zenoh", "zenoh"], {"one", "three", "four"}),
        ("d", "four", ["ring", "zenoh", "zenoh"], set()),
    ],
)
def test_edges_change_their_kind_and_only_who_is_concerned_begins_anew(
    tmp_path: Path, stage: str, place: str, after: list[str], begin: set[str]
) -> None:
    plan = planned(tmp_path)
    assert kinds(plan) == ["ring", "zenoh", "zenoh"]
    new = plan_after_move(plan, [stage], place)
    assert kinds(new) == after
    assert restarted_workers(plan, new) == begin
    running = {worker.name for worker in new.workers}
    assert running == {s.worker for s in new.stages}, "a worker without stages is gone"


def test_several_go_together_and_what_is_between_them_stays_near(tmp_path: Path) -> None:
    new = plan_after_move(planned(tmp_path), ["a", "b", "c"], "four")
    assert kinds(new) == ["reference", "reference", "reference"]
    assert [worker.name for worker in new.workers] == ["four"]


@pytest.mark.parametrize(
    ("source", "stage", "place", "said"),
    [
        ("live", "e", "one", 'no stage "e"'),
        ("live", "a", "five", 'no worker or host "five"'),
        ("count", "a", "two", "live runs only"),
    ],
)
def test_what_cannot_move_is_said(tmp_path: Path, source: str, stage: str, place: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        plan_after_move(planned(tmp_path, source), [stage], place)

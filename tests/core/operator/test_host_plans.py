"""The plans of the hosts of a run: the parts that each knows, and hosts that have different ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from followspot.control.plan_transfer import packed
from followspot.graph.change.move import plan_after_move
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data
from followspot.operator.host_plans import PlanConflict, merged_plan, plan_conflict

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a: {uses: ticks.live}
  b: {uses: ticks.tally, in: {number: a}, with: {step: 3}}
  c: {uses: ticks.tally, in: {number: b}, with: {step: 5}}
"""
PLACEMENT = """
placement: p
workers:
  left:  {host: pc-left, stages: [a, b]}
  right: {host: pc-right, stages: [c]}
"""


@pytest.fixture
def old(tmp_path: Path) -> Plan:
    (tmp_path / "g.yaml").write_text(GRAPH)
    (tmp_path / "p.yaml").write_text(PLACEMENT)
    return compile_graph(tmp_path / "g.yaml", placement=tmp_path / "p.yaml", plugin_files=[TICKS])


@pytest.fixture
def new(old: Plan) -> Plan:
    return plan_after_move(old, ["b"], "pc-right")


def there(left: Plan, right: Plan) -> dict[str, Plan]:
    """The plans as the agents of the two hosts give them."""
    hosts = {"pc-left": left, "pc-right": right}
    return {host: plan_from_data(packed(plan, host, Path())) for host, plan in hosts.items()}


def found(plans: dict[str, Plan]) -> PlanConflict:
    known = plan_conflict(plans, merged_plan(plans))
    assert known is not None
    return known


def test_the_plan_of_a_run_has_the_parameters_that_each_host_knows_of_its_stages(old: Plan) -> None:
    plans = there(old, old)
    assert [stage.params.get("step") for stage in merged_plan(plans).stages] == [None, 3, 5]
    assert plan_conflict(plans, merged_plan(plans)) is None


def test_stages_swapped_on_one_host_alone_are_no_conflict(old: Plan) -> None:
    swapped = replace(old.stages[0], uses="ticks.count")
    plans = there(replace(old, stages=(swapped, *old.stages[1:])), old)
    assert merged_plan(plans).stages[0].uses == "ticks.count"
    assert plan_conflict(plans, merged_plan(plans)) is None


def test_a_host_that_gets_a_stage_has_its_parameters_before_the_other_drops_them(
    old: Plan, new: Plan
) -> None:
    plans = there(old, new)
    assert [stage.params.get("step") for stage in merged_plan(plans).stages] == [None, 3, 5]
    assert found(plans).curable
    assert found(plans).workers(merged_plan(plans)) == {"left", "right"}


def test_a_stage_without_parameters_anywhere_cannot_be_placed_again(old: Plan, new: Plan) -> None:
    plans = there(new, old)
    assert not found(plans).curable
    assert found(plans).text.endswith("stop the run, and start it anew")


def test_a_replay_would_lose_messages(old: Plan, new: Plan) -> None:
    replays = [replace(p, stages=tuple(replace(s, live=False) for s in p.stages)) for p in (old, new)]
    assert not found(there(*replays)).curable

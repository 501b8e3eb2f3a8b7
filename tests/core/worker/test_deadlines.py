"""How long live joins wait for what is missing."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.worker.solo import Solo

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


SAMPLED = """
graph: g
stages:
  a:    {uses: rates.device}
  b:    {uses: rates.device}
  near: {uses: rates.near, in: {frame: a, reading: b}, deadline: 0.2}
  all:  {uses: rates.gather, in: {frame: a, readings: b}, deadline: 0.3}
  held: {uses: rates.mix, in: {frame: a, latest: b}, deadline: 0.4}
"""


def test_a_stage_waits_for_the_messages_of_a_nearest_or_a_window_but_not_of_a_latest(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(SAMPLED)
    rates = TICKS.with_name("rates.py")
    wiring = Wiring(compile_graph(tmp_path / "g.yaml", plugin_files=[rates]))
    assert [wiring.deadline[name] for name in ("near", "all", "held")] == [0.2, 0.3, 0.0]


def test_a_join_waits_for_what_a_join_upstream_makes_without_those_missing(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(JOINS)
    use_plugin_files([str(TICKS)])
    wiring = Wiring(compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS]))
    assert wiring.deadline["sum"] == 0.1
    assert wiring.deadline["all"] == pytest.approx(0.15), "b is given up by then, and the sum is on its way"


SLOW = """
graph: g
stages:
  a:   {uses: ticks.live, with: {count: 1}}
  one: {uses: ticks.add, in: {number: a}, with: {sleep: 0.03}}
  two: {uses: ticks.add, in: {number: a}, with: {sleep: 0.03}}
  six: {uses: ticks.add, in: {number: a}, with: {sleep: 0.03}}
  sum: {uses: ticks.sum, in: {numbers: [one, two, six]}, deadline: 0.001}
"""


def test_what_waits_for_a_slow_stage_of_the_same_worker_is_not_missing(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(SLOW)
    use_plugin_files([str(TICKS)])
    report = Solo(compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS]), tmp_path).run()
    into = [count for edge, count in report.edges if edge.to_stage == "sum"]
    fired = {row.stage: row.fired for worker in report.workers for row in worker.stages}
    assert [count.delivered for count in into] == [fired["sum"]] * 3
    assert not any(count.late for count in into)

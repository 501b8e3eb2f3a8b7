"""When workers are started again."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.compile import compile_graph
from followspot.host.heartbeat import BackOff, fed

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
CHAIN = """
graph: g
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.add, in: {number: a}}
  c: {uses: ticks.write, in: {number: b}}
"""


def test_a_worker_that_dies_again_and_again_is_started_less_and_less_often() -> None:
    back_off = BackOff()
    waits = [back_off.wait("main", 7.0 * number) for number in range(9)]
    assert waits[:3] == [0.1, 0.2, 0.4]
    assert waits[-1] == 5.0


def test_a_worker_that_lived_for_a_while_is_started_at_once_again_and_others_are_not_its_fault() -> None:
    back_off = BackOff()
    for number in range(5):
        back_off.wait("main", number)
    assert back_off.wait("cam0", 5.0) == 0.1
    assert back_off.wait("main", 60.0) == 0.1


def test_a_worker_is_started_again_as_long_as_something_can_come_to_it(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(CHAIN)
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS])
    assert fed(plan, "a", over={"b", "c"}), "it has a source"
    assert fed(plan, "b", over={"c"})
    assert fed(plan, "c", over={"a"}), "b may still send"
    assert not fed(plan, "b", over={"a"})
    assert not fed(plan, "c", over={"a", "b"})

"""When dead workers are restarted."""

from __future__ import annotations

from pathlib import Path

from tests.core.host.chain import chain_plan

from followspot.host.restart_policy import BackOff, may_get_messages


def test_the_wait_before_a_restart_grows_with_each_death() -> None:
    back_off = BackOff()
    waits = [back_off.wait("main", 7.0 * number) for number in range(9)]
    assert waits[:3] == [0.1, 0.2, 0.4]
    assert waits[-1] == 2.0


def test_the_wait_is_short_again_after_a_long_life_and_separate_for_each_worker() -> None:
    back_off = BackOff()
    for number in range(5):
        back_off.wait("main", number)
    assert back_off.wait("cam0", 5.0) == 0.1
    assert back_off.wait("main", 60.0) == 0.1


def test_a_worker_is_restarted_as_long_as_messages_can_reach_it(tmp_path: Path) -> None:
    plan = chain_plan(tmp_path)
    assert may_get_messages(plan, "a", over={"b", "c"}), "it has a source"
    assert may_get_messages(plan, "b", over={"c"})
    assert may_get_messages(plan, "c", over={"a"}), "b may still send"
    assert not may_get_messages(plan, "b", over={"a"})
    assert not may_get_messages(plan, "c", over={"a", "b"})

"""When workers are started again."""

from __future__ import annotations

from followspot.deploy.supervision import BackOff


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

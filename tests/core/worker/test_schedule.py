"""In a worker with live sources, each stage fires at most once before its sources have their turn."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from followspot.worker.schedule import Schedule


def arranged(log: list[int], *more: int) -> Schedule:
    """Three stages in a chain, in rounds; each marks the next, and those in `more` always have more."""
    schedule = Schedule()

    def fire(rank: int) -> bool:
        log.append(rank)
        if rank < 2:
            schedule.mark(rank + 1)
        return rank in more

    runners: list[Any] = [
        SimpleNamespace(rank=n, stage=SimpleNamespace(process_together=None), fire=lambda n=n: fire(n))
        for n in range(3)
    ]
    schedule.arrange(runners, in_rounds=True)
    return schedule


def test_a_message_passes_a_chain_in_one_round() -> None:
    log: list[int] = []
    schedule = arranged(log)
    schedule.mark(0)
    schedule.fire()
    assert log == [0, 1, 2]
    assert not schedule.ready


def test_a_stage_that_has_more_waits_for_the_next_round() -> None:
    """A stage before it marks it again: it has stepped in this round."""
    log: list[int] = []
    schedule = arranged(log, 1)
    schedule.mark(1)
    schedule.mark(0)
    schedule.fire()
    assert log == [1, 2, 0]
    assert [-rank for rank in schedule.ready] == [1]
    schedule.fire()
    assert log == [1, 2, 0, 1, 2]

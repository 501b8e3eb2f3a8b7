"""Batch groups: alike stages of one worker that process together, at less cost than each alone.

A ready member waits for the other members, but never for another worker: the scheduler fires the ready ones
as soon as nothing else can go on. Batching never changes a result, for a stage returns the same either way.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any

from followspot.worker.runners.error_policy import RAISED, text_of
from followspot.worker.runners.stage_runner import FiringInputs, StageRunner


class BatchGroup:
    """Stage runners that fire together; mark: schedules the stage runner of a rank."""

    def __init__(self, runners: Sequence[StageRunner], mark: Callable[[int], None]) -> None:
        self.runners = tuple(runners)
        self.mark = mark
        self.waiting: dict[StageRunner, int] = {}
        """Members that are ready, with the capture time of their firing, ns."""
        self.living = {runner for runner in runners if not runner.done}

    def step(self, runner: StageRunner) -> None:
        """Note whether a member is ready; fire if all that have not ended are. Raises StageError.

        A waiting member that is scheduled again means the others lag: fire without them.
        """
        lags = runner in self.waiting
        fire_at = runner.due()
        if fire_at is not None:
            self.waiting[runner] = fire_at
        elif runner.done:
            self.living.discard(runner)
        else:
            return
        if lags or len(self.waiting) == len(self.living):
            self.fire()

    def fire(self) -> None:
        """Fire all ready members. Raises StageError if one raises whose policy is `fail`."""
        runners = list(self.waiting)
        firings = [runner.take(fire_at) for runner, fire_at in self.waiting.items()]
        self.waiting.clear()
        results = _together(runners, firings) if len(runners) > 1 else _each_alone(runners, firings)
        for runner, firing, result in zip(runners, firings, results, strict=True):
            runner.deliver(result, firing.header)
            if runner.has_more():
                self.mark(runner.rank)


def batch_groups(runners: Sequence[StageRunner], mark: Callable[[int], None]) -> list[BatchGroup]:
    """The batch groups of a worker: two or more runners of one stage class with equal parameters, that know
    the same cameras.
    """
    alike: dict[tuple[type, str, tuple[str, ...]], list[StageRunner]] = defaultdict(list)
    for runner in runners:
        stage = runner.stage
        if stage.process_together is not None and type(runner) is StageRunner:
            alike[type(stage), stage.params.model_dump_json(), tuple(stage.room.cameras)].append(runner)
    return [BatchGroup(members, mark) for members in alike.values() if len(members) > 1]


def _together(runners: Sequence[StageRunner], firings: Sequence[FiringInputs]) -> Sequence[Any]:
    """The results of the stages; if the batch raises, each works alone, so that errors name their stage."""
    started = time.monotonic_ns()
    for runner in runners:
        runner.working = True
    try:
        together: Any = runners[0].stage.process_together
        results: Sequence[Any] = together([c.stage for c in runners], [f.arguments for f in firings])
        if len(results) != len(runners):
            raise ValueError(f"process_together returned {len(results)} outputs for {len(runners)} stages")
    except RAISED as error:
        runners[0].stage.context.warn(f"each works alone, for together {text_of(error)}")
        return _each_alone(runners, firings)
    finally:
        for runner in runners:
            runner.working = False
    share = (time.monotonic_ns() - started) // len(runners)
    for runner in runners:
        runner.count.busy_ns += share
    return results


def _each_alone(runners: Sequence[StageRunner], firings: Sequence[FiringInputs]) -> Sequence[Any]:
    return [runner.run(firing) for runner, firing in zip(runners, firings, strict=True)]

"""Stage runners of one worker whose stages are alike and can work together, for less than each alone.

A member that is ready waits for the others, but never for anything from outside: the worker fires those that
are ready as soon as nothing else can go on. Who fires together never changes a result, for what a stage
returns together is what it returns alone.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any

from followspot.worker.source import SourceRunner
from followspot.worker.stage_runner import Firing, StageRunner


class BatchGroup:
    """Stage runners that fire together.

    mark: tells the worker to look at the stage runner of this rank again.
    """

    def __init__(self, runners: Sequence[StageRunner], mark: Callable[[int], None]) -> None:
        self.runners = tuple(runners)
        self.mark = mark
        self.waiting: dict[StageRunner, int] = {}
        """Members that are ready, with the capture time of their firing, ns."""
        self.living = {runner for runner in runners if not runner.done}

    def step(self, runner: StageRunner) -> None:
        """Look at a member; fire where all that have not ended are ready. Raises StageError.

        One that waits and is looked at again has got more to do: the others lag behind, and are left.
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
        """Fire all that are ready. Raises StageError where the policy of one that raises is `fail`."""
        runners = list(self.waiting)
        firings = [runner.take(fire_at) for runner, fire_at in self.waiting.items()]
        self.waiting.clear()
        results = _together(runners, firings) if len(runners) > 1 else _each_alone(runners, firings)
        for runner, firing, result in zip(runners, firings, results, strict=True):
            runner.deliver(result, firing.header)
            if runner.has_more():
                self.mark(runner.rank)


def batch_groups(runners: Sequence[StageRunner], mark: Callable[[int], None]) -> list[BatchGroup]:
    """Teams of two stage runners or more among the stage runners of a worker."""
    alike: dict[tuple[type, str], list[StageRunner]] = defaultdict(list)
    for runner in runners:
        if runner.stage.process_together is not None and not isinstance(runner, SourceRunner):
            alike[type(runner.stage), runner.stage.params.model_dump_json()].append(runner)
    return [BatchGroup(members, mark) for members in alike.values() if len(members) > 1]


def _together(runners: Sequence[StageRunner], firings: Sequence[Firing]) -> Sequence[Any]:
    """What the stages return; where that raises, each works alone, so that the guilty one is named."""
    started = time.monotonic_ns()
    for runner in runners:
        runner.working = True
    try:
        together: Any = runners[0].stage.process_together
        results: Sequence[Any] = together([c.stage for c in runners], [f.arguments for f in firings])
        if len(results) != len(runners):
            raise ValueError(f"process_together returned {len(results)} outputs for {len(runners)} stages")
    except Exception as error:
        runners[0].stage.context.warn(f"each works alone, for together {type(error).__name__}: {error}")
        return _each_alone(runners, firings)
    finally:
        for runner in runners:
            runner.working = False
    share = (time.monotonic_ns() - started) // len(runners)
    for runner in runners:
        runner.count.busy_ns += share
    return results


def _each_alone(runners: Sequence[StageRunner], firings: Sequence[Firing]) -> Sequence[Any]:
    return [runner.run(firing) for runner, firing in zip(runners, firings, strict=True)]

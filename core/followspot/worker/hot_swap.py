"""Stages that take the place of others in a graph that runs: built beside them, put in between firings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from followspot.errors import FollowspotError
from followspot.graph.plan import PlannedStage
from followspot.plugins.registry import load_stage
from followspot.stage import Stage
from followspot.worker.scheduler import Worker
from followspot.worker.stage_runner import StageRunner


@dataclass(frozen=True)
class Replacement:
    """A stage that is set up and waits to take the place of the one in a stage runner."""

    runner: StageRunner
    stage: Stage
    build: Callable[[], Stage]


def prepared(worker: Worker, stages: Sequence[PlannedStage]) -> list[Replacement]:
    """Build and set up the successors of stages of a worker, in any thread; the old ones work on.

    Raises FollowspotError with the reason where one of them cannot be; then none is left.
    """
    runners = {runner.name: runner for runner in worker.runners}
    replacements: list[Replacement] = []
    for planned in stages:
        runner = runners[planned.name]
        try:
            build = partial(load_stage(planned.uses), runner.stage.context, **planned.params)
            stage = build()
            replacements.append(Replacement(runner, stage, build))
            stage.setup()
        except Exception as error:
            discarded(replacements)
            reason = str(error) if isinstance(error, FollowspotError) else f"{type(error).__name__}: {error}"
            raise FollowspotError(
                f"stage {planned.name} ({planned.uses}) cannot be built: {reason}"
            ) from error
    return replacements


def dry_run(replacements: Sequence[Replacement]) -> None:
    """Let successors carry on from the state that the old ones have now, to see whether they can.

    Call between two firings, in the worker's thread. Raises FollowspotError; then none is left.
    """
    try:
        for replacement in replacements:
            _carry_on(replacement)
    except FollowspotError:
        discarded(replacements)
        raise


def take_over(worker: Worker, replacements: Sequence[Replacement], *, fresh: bool) -> None:
    """Put the successors into their stage runners; call between two firings, in the worker's thread.

    fresh: begin without the state of the old ones; else a successor carries on from it where both know how.
    Raises FollowspotError where it cannot; then the old ones go on, all of them.
    """
    while worker.fire_waiting():
        pass
    dry_run([] if fresh else replacements)
    for replacement in replacements:
        old = replacement.runner.stage
        replacement.runner.succeed(replacement.stage, replacement.build)
        _close(old)
    worker.regroup()


def discarded(replacements: Sequence[Replacement]) -> None:
    """Close successors that will not take over."""
    for replacement in replacements:
        _close(replacement.stage)


def _carry_on(replacement: Replacement) -> None:
    if type(replacement.stage).restore is Stage.restore:
        return
    try:
        state = replacement.runner.stage.state()
        if state is not None:
            replacement.stage.restore(state)
    except Exception as error:
        raise FollowspotError(
            f"stage {replacement.runner.name} cannot carry on from the state of the one before "
            f"({type(error).__name__}: {error}); --fresh begins without it"
        ) from error


def _close(stage: Stage) -> None:
    try:
        stage.close()
    except Exception as error:
        stage.context.warn(f"the stage whose place was taken did not close: {type(error).__name__}: {error}")

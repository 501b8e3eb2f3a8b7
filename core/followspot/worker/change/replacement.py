"""Replacements of stages: built beside those that work, tested, and put in between two firings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from followspot.errors import FollowspotError
from followspot.graph.plan import PlannedStage
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.worker.runners.forked_copy import set_up
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler


@dataclass(frozen=True)
class Replacement:
    """A stage that is set up and ready to replace the one in a stage runner."""

    runner: StageRunner
    stage: Stage
    build: Callable[[], Stage]
    uses: str

    def take_over(self) -> None:
        """Put the stage into its stage runner, and close the one before; call between two firings."""
        old = self.runner.stage
        self.runner.replace_stage(self.stage, self.build)
        self.runner.uses = self.uses
        self.runner.retire(old)


def fits(runner: StageRunner, stage: PlannedStage) -> bool:
    """Whether the stage, or a replacement in the same runner, can follow the new plan."""
    before, after = ports(type(runner.stage)), ports(load_stage(stage.uses))
    alike = (before.source, before.gives, type(runner.stage).live) == (
        after.source,
        after.gives,
        load_stage(stage.uses).live,
    )
    given = {(port.name, port.type) for port in before.outputs}
    same = given == {(port.name, port.type) for port in after.outputs}
    return alike and same and runner.stage.context.member == stage.member


def is_same(runner: StageRunner, stage: PlannedStage) -> bool:
    """Whether the stage that works is the planned one already."""
    now = runner.stage
    return type(now) is load_stage(stage.uses) and now.params == type(now).Params(**stage.params)


def build_replacements(scheduler: Scheduler, stages: Sequence[PlannedStage]) -> list[Replacement]:
    """Build and set up replacements for stages of a worker, in any thread, while the old ones work on.

    Raises FollowspotError with the reason if one cannot be built; all are closed then.
    """
    runners = {runner.name: runner for runner in scheduler.runners}
    replacements: list[Replacement] = []
    for planned in stages:
        runner = runners[planned.name]
        try:
            context = replace(runner.stage.context, resumed=True)
            build = partial(load_stage(planned.uses), context, **planned.params)
            stage = build()
            replacements.append(Replacement(runner, stage, build, planned.uses))
            set_up(stage).forget()
        except Exception as error:
            discard_all(replacements)
            reason = str(error) if isinstance(error, FollowspotError) else f"{type(error).__name__}: {error}"
            raise FollowspotError(
                f"stage {planned.name} ({planned.uses}) cannot be built: {reason}"
            ) from error
    return replacements


def dry_run(replacements: Sequence[Replacement]) -> None:
    """Let replacements restore checkpoints that the old stages make now, to see whether they can.

    Call between two firings, in the worker's thread. Raises FollowspotError; all are closed then.
    """
    try:
        for replacement in replacements:
            _restore_checkpoint(replacement)
    except FollowspotError:
        discard_all(replacements)
        raise


def take_over(scheduler: Scheduler, replacements: Sequence[Replacement], *, fresh: bool) -> None:
    """Put the replacements into their stage runners; call between two firings, in the worker's thread.

    fresh: begin without checkpoints; else a replacement restores that of the old stage, if both classes can.
    Raises FollowspotError if one cannot; all old stages go on then.
    """
    while scheduler.schedule.fire_waiting():
        pass
    dry_run([] if fresh else replacements)
    for replacement in replacements:
        replacement.take_over()
    scheduler.schedule.regroup()


def discard_all(replacements: Sequence[Replacement]) -> None:
    """Close replacements that will not take over."""
    for replacement in replacements:
        replacement.runner.retire(replacement.stage)


def _restore_checkpoint(replacement: Replacement) -> None:
    """Let a replacement carry on from the present state of the old stage. Raises FollowspotError."""
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

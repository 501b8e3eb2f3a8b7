"""Stages that take the place of others in a graph that runs: built beside them, put in between firings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from followspot.errors import FollowspotError
from followspot.graph.plan import PlannedStage
from followspot.plugins.registry import load_stage
from followspot.runtime.cell import Cell
from followspot.runtime.worker import Worker
from followspot.stage import Stage


@dataclass(frozen=True)
class Successor:
    """A stage that is set up and waits to take the place of the one in a cell."""

    cell: Cell
    stage: Stage
    build: Callable[[], Stage]


def prepared(worker: Worker, stages: Sequence[PlannedStage]) -> list[Successor]:
    """Build and set up the successors of stages of a worker, in any thread; the old ones work on.

    Raises FollowspotError with the reason where one of them cannot be; then none is left.
    """
    cells = {cell.name: cell for cell in worker.cells}
    successors: list[Successor] = []
    for planned in stages:
        cell = cells[planned.name]
        try:
            build = partial(load_stage(planned.uses), cell.stage.context, **planned.params)
            stage = build()
            successors.append(Successor(cell, stage, build))
            stage.setup()
        except Exception as error:
            given_up(successors)
            reason = str(error) if isinstance(error, FollowspotError) else f"{type(error).__name__}: {error}"
            raise FollowspotError(
                f"stage {planned.name} ({planned.uses}) cannot be built: {reason}"
            ) from error
    return successors


def rehearse(successors: Sequence[Successor]) -> None:
    """Let successors carry on from the state that the old ones have now, to see whether they can.

    Call between two firings, in the worker's thread. Raises FollowspotError; then none is left.
    """
    try:
        for successor in successors:
            _carry_on(successor)
    except FollowspotError:
        given_up(successors)
        raise


def take_over(worker: Worker, successors: Sequence[Successor], *, fresh: bool) -> None:
    """Put the successors into their cells; call between two firings, in the worker's thread.

    fresh: begin without the state of the old ones; else a successor carries on from it where both know how.
    Raises FollowspotError where it cannot; then the old ones go on, all of them.
    """
    while worker.fire_waiting():
        pass
    rehearse([] if fresh else successors)
    for successor in successors:
        old = successor.cell.stage
        successor.cell.succeed(successor.stage, successor.build)
        _close(old)
    worker.regroup()


def given_up(successors: Sequence[Successor]) -> None:
    """Close successors that will not take over."""
    for successor in successors:
        _close(successor.stage)


def _carry_on(successor: Successor) -> None:
    if type(successor.stage).restore is Stage.restore:
        return
    try:
        state = successor.cell.stage.state()
        if state is not None:
            successor.stage.restore(state)
    except Exception as error:
        raise FollowspotError(
            f"stage {successor.cell.name} cannot carry on from the state of the one before "
            f"({type(error).__name__}: {error}); --fresh begins without it"
        ) from error


def _close(stage: Stage) -> None:
    try:
        stage.close()
    except Exception as error:
        stage.context.warn(f"the stage whose place was taken did not close: {type(error).__name__}: {error}")

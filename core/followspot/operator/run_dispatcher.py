"""The dispatcher of a run's operator: the handler of each request of other processes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from followspot.control.dispatch import Dispatcher
from followspot.control.lifecycle import StopRun
from followspot.control.observation import GetLog
from followspot.control.worker_orders import RELAYED
from followspot.graph.plan_data import plan_to_data
from followspot.operator.change.hot_swap import change_stages
from followspot.operator.change.move import move_stages
from followspot.operator.coordinator import Coordinator
from followspot.operator.mark_queue import MarkQueue
from followspot.operator.run_requests import (
    ChangeStages,
    ExchangeMarks,
    GetPlan,
    GetRecorderState,
    GetRunMetadata,
    GetStatus,
    MarkMoment,
    MoveStages,
    RunMetadata,
)
from followspot.operator.run_status import RunStatus


def run_dispatcher(
    run: Coordinator, metadata: RunMetadata, stop: Callable[[], None] | None = None
) -> Dispatcher:
    """The dispatcher of a run's requests. Safe from any thread.

    stop: ends the sources of the run; `Coordinator.stop` by default.
    """
    end = run.stop if stop is None else stop
    marks = MarkQueue(run.log.say)

    def status(_: GetStatus) -> RunStatus:
        found = run.status()
        return replace(found, workers=tuple(replace(worker, report=None) for worker in found.workers))

    return Dispatcher(
        "operator",
        {
            GetPlan: lambda _: plan_to_data(run.plan),
            GetStatus: status,
            GetLog: lambda request: run.records(request.after),
            GetRunMetadata: lambda _: metadata,
            ChangeStages: partial(change_stages, run),
            MoveStages: partial(move_stages, run),
            MarkMoment: lambda request: marks.mark(request.after, request.note),
            ExchangeMarks: lambda request: marks.exchange(request.kept, request.taken),
            GetRecorderState: lambda _: marks.kept,
            **dict.fromkeys(RELAYED, run.relay),
            StopRun: lambda _: end(),
        },
    )

"""Requests to a run's operator, which its coordinator answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from followspot.control.dispatch import Dispatcher, Request, Role
from followspot.control.lifecycle import StopRun
from followspot.control.observation import GetLog
from followspot.control.worker_orders import RELAYED
from followspot.graph.ship import plan_to_data
from followspot.operator.changed import Changed, Moved
from followspot.operator.coordinator import Coordinator
from followspot.operator.run_status import RunStatus
from followspot.transport.zenoh.network import Network


@dataclass(frozen=True)
class Surroundings:
    """The surroundings of a run.

    out: its output folder on the operator's host, None if that is not this host; network: leads to its other
    hosts, None if it has none.
    """

    out: Path | None = None
    network: Network | None = None


class _OperatorRequest(Request):
    roles: ClassVar[tuple[Role, ...]] = ("operator",)


class GetPlan(_OperatorRequest):
    """The plan as it is now, as `plan_to_data` gives it."""

    answer: ClassVar[Any] = dict[str, Any]


class GetStatus(_OperatorRequest):
    """The status of the run, without the reports of ended workers."""

    answer: ClassVar[Any] = RunStatus


class GetSurroundings(_OperatorRequest):
    """The output folder of the run, and the network that leads to its hosts."""

    answer: ClassVar[Any] = Surroundings


class ChangeStages(_OperatorRequest):
    """Swap stages (`fuse=balls.mean`) and set parameters (`color.similarity=0.7`), all or none.

    folder: base of relative paths; fresh: whether replacements start without the state of the old stages.
    """

    words: tuple[str, ...]
    folder: Path = Path()
    fresh: bool = False
    answer: ClassVar[Any] = Changed


class MoveStages(_OperatorRequest):
    """Move stages to another worker or host."""

    stages: tuple[str, ...]
    place: str
    answer: ClassVar[Any] = Moved


def run_dispatcher(
    run: Coordinator, surroundings: Surroundings, stop: Callable[[], None] | None = None
) -> Dispatcher:
    """The dispatcher of a run's requests. Safe from any thread.

    stop: ends the sources of the run; `Coordinator.stop` by default.
    """
    end = run.stop if stop is None else stop

    def status(_: GetStatus) -> RunStatus:
        found = run.status()
        return replace(found, workers=tuple(replace(worker, report=None) for worker in found.workers))

    return Dispatcher(
        "operator",
        {
            GetPlan: lambda _: plan_to_data(run.plan),
            GetStatus: status,
            GetLog: lambda request: run.records(request.after),
            GetSurroundings: lambda _: surroundings,
            ChangeStages: lambda request: run.change(request.words, request.folder, fresh=request.fresh),
            MoveStages: lambda request: run.move(request.stages, request.place),
            **dict.fromkeys(RELAYED, run.relay),
            StopRun: lambda _: end(),
        },
    )

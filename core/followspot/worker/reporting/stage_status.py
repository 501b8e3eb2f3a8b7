"""Status of stages: what each is doing now, and for which edges or stages it waits."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace

from followspot.control.stage_status import EdgeAge, PathStatus, StageState, StageStatus
from followspot.transport.token import END
from followspot.worker.clock import Clock
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import COLUMNS, tally
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.live_source import LiveSourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler


def stages_now(scheduler: Scheduler, errors: Mapping[str, str]) -> tuple[StageStatus, ...]:
    """Status of all stages of a worker; safe from another thread. errors: the last warning of each stage."""
    at_work = next((runner.name for runner in scheduler.runners if runner.working), "")
    found = (_status(runner, errors.get(runner.name, ""), at_work) for runner in scheduler.runners)
    return tuple(map(scheduler.sources.hold.shown, scheduler.runners, found))


class Idleness:
    """Time since each stage fired last, from status reports one after the other; monotonic: a clock, s."""

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._clock = monotonic
        self._since: dict[str, tuple[int, float]] = {}

    def noted(self, stages: Iterable[StageStatus]) -> Iterator[StageStatus]:
        """The statuses, with the time for which each stage has not fired."""
        now = self._clock()
        for stage in stages:
            fired, since = self._since.get(stage.stage, (-1, now))
            since = since if fired == stage.fired else now
            self._since[stage.stage] = stage.fired, since
            yield replace(stage, idle_s=round(max(0.0, now - since), 3))  # two threads may ask at once


def paths_now(scheduler: Scheduler) -> tuple[PathStatus, ...]:
    """Latency of all paths that end in this worker; safe from another thread."""
    return tuple(
        path.status(origin, runner.name)
        for runner in scheduler.runners
        for origin, path in tuple(runner.paths.items())
    )


def _status(runner: StageRunner, error: str, at_work: str) -> StageStatus:
    """Status of one stage; see `stages_now`."""
    state, on = _state(runner, at_work)
    queues = [queue for port in runner.join.ports for queue in port.queues]
    invalid = next((f"{i.name}: {i.invalid_reason}" for i in queues if i.invalid_reason), "")
    count = runner.count
    return StageStatus(
        stage=runner.name,
        state=state,
        on=on,
        fired=count.fired,
        skipped=count.skipped,
        restarts=count.restarts,
        busy_ms=round(count.busy_ns / 1e6, 3),
        error=error or invalid,
        edges=tuple(_age(queue, runner.clock) for queue in queues),
    )


def _age(queue: InputQueue, clock: Clock) -> EdgeAge:
    """Ages of the messages of one edge when they were taken."""
    ages = sorted(queue.ages.copy())
    if not ages:
        return EdgeAge(queue.name, None, None, queue.invalid_reason)
    p50, p95 = (round((ages[int(share * len(ages))] + clock.steady) / 1e6, 3) for share in (0.5, 0.95))
    return EdgeAge(queue.name, p50, p95, queue.invalid_reason)


def _full(output: OutputPort) -> Iterator[str]:
    """Edges whose backpressure blocks an output: full queues here, and the slowest edges to other workers.

    If all is accounted for, credit has not come back, over any of the edges to other workers.
    """
    full = [queue.name for queue in output.queues if len(queue.messages) >= queue.depth]
    yield from full
    words = output.words
    behind = {name: tally(words[row : row + COLUMNS].tolist()).in_flight for name, row in output.edges}
    most = max(behind.values(), default=0)
    if most or not full:
        yield from (name for name, waiting in behind.items() if waiting == most)


def _state(runner: StageRunner, at_work: str) -> tuple[StageState, tuple[str, ...]]:
    """State of a stage, and for what it waits; at_work: the stage that its worker runs now, "" for none."""
    if runner.done:
        return "over", ()
    if runner.absent:
        return "absent", tuple(queue.name for queue in runner.join.members)
    if runner.blocked:
        return "sending", tuple(name for _, output in runner.outputs for name in _full(output))
    if runner.working or runner.asks:
        return "processing", ()
    dry = tuple(i.name for i in runner.join.members if not i.messages and i.watermark != END) or _awaited(
        runner
    )
    if dry or (isinstance(runner, LiveSourceRunner) and runner.grabbing):
        return "getting", dry
    return "waiting", (at_work,) if at_work else ()


def _awaited(runner: StageRunner) -> tuple[str, ...]:
    """Edges to sampled inputs for which the next firing waits."""
    times = [
        messages[0].header.time for messages in (i.messages.copy() for i in runner.join.members) if messages
    ]
    if not times:
        return ()
    return tuple(name for sampled in runner.join.sampled for name in sampled.awaited(min(times)))

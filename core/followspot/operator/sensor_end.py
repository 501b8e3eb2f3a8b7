"""Ends the sensors of a run of N frames at the last capture time of its cameras, in every placement."""

from __future__ import annotations

from collections.abc import Iterable

from followspot.control.host import WorkerStatus
from followspot.control.worker_orders import EndSensors
from followspot.graph.frame_count import accompanying_sources, counted_sources
from followspot.graph.plan import Plan


def order_at_start(plan: Plan, workers: Iterable[WorkerStatus]) -> EndSensors | None:
    """The order if every source of frames knows its last capture time beforehand: results are exact then.

    None for live runs as well: their sensors end when the devices have given their frames.
    """
    known = {name: time for worker in workers for name, time in worker.last_times.items()}
    counted = counted_sources(plan)
    if plan.live or not counted <= known.keys():
        return None
    return _order(plan, (known[name] for name in counted))


def order_at_end(plan: Plan, workers: Iterable[WorkerStatus]) -> EndSensors | None:
    """The order once every source of frames has ended, None before."""
    ended = ended_stages(workers)
    counted = counted_sources(plan)
    return _order(plan, (ended[name] for name in counted)) if counted <= ended.keys() else None


def _order(plan: Plan, times: Iterable[int]) -> EndSensors:
    return EndSensors(sensors=tuple(sorted(accompanying_sources(plan))), time=max(times, default=-1))


def ended_stages(workers: Iterable[WorkerStatus]) -> dict[str, int]:
    """The stages that have ended, each with its newest capture time, ns."""
    return {
        stage.stage: stage.time
        for worker in workers
        for stage in worker.stages
        if stage.state == "over" or worker.phase == "over"
    }

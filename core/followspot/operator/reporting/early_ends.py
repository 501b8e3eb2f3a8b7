"""Sources that ended before others of their kind: the run goes on without them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from followspot.control.worker_report import StageReport, WorkerReport
from followspot.frame_times import to_ns, to_seconds
from followspot.graph.plan import Plan

EARLY = to_ns(1.0)
"""Time before the last message of all of its kind by which a source must end for a user to be told, ns."""


def early_ends(plan: Plan, workers: Sequence[WorkerReport]) -> Mapping[str, str]:
    """A line for each source, by its name, that ended by itself a second or more before another instance of
    the same stage of the graph file.
    """
    reports = {stage.stage: stage for worker in workers for stage in worker.stages}
    groups: dict[str, list[StageReport]] = defaultdict(list)
    for planned in plan.stages:
        if (report := reports.get(planned.name)) is not None and report.time >= 0:
            groups[planned.group].append(report)
    found = {}
    for sources in groups.values():
        last = max(sources, key=lambda one: one.time)
        for one in sources:
            if one.exhausted and last.time - one.time >= EARLY:
                found[one.stage] = _line(one, last)
    return found


def _line(early: StageReport, last: StageReport) -> str:
    by = to_seconds(last.time - early.time)
    return (
        f"{early.stage} ended after {early.fired} messages, {by:.2f} s before {last.stage}: its recording is "
        "cut off, or has no entries where nothing was seen"
    )

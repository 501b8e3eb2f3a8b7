"""Parameters of a sweep that changed nothing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from followspot.cli.trial_outputs import same_outputs
from followspot_sweep.axes import Axis, Point
from followspot_sweep.trial import SUMMARY, Result, Task


def axes_without_effect(results: Sequence[Result], axes: Sequence[Axis]) -> list[str]:
    """Names of the axes whose values all gave the same files, for all values of other axes and rooms.

    No names if a run failed, for its files are not complete.
    """
    if any(result.error for result in results):
        return []
    tasks = [result.task for result in results]
    return [axis.name for axis in axes if len(axis.values) > 1 and _changes_nothing(axis.name, tasks)]


def _changes_nothing(name: str, tasks: Sequence[Task]) -> bool:
    alike: dict[tuple[str, Point], list[Task]] = defaultdict(list)
    for task in tasks:
        alike[task.room, tuple(pair for pair in task.point if pair[0] != name)].append(task)
    return all(
        same_outputs(first.folder, other.folder, (SUMMARY,))
        for first, *others in alike.values()
        for other in others
    )

"""A graph that is stuck: the stages that wait, and the edges for which they wait."""

from __future__ import annotations

from collections.abc import Iterable

from followspot.errors import FollowspotError
from followspot.transport.token import END
from followspot.worker.runners.stage_runner import StageRunner


class StuckError(FollowspotError):
    """No stage can fire, no source can yield, and yet the streams have not ended."""

    def __init__(self, runners: Iterable[StageRunner]) -> None:
        lines = [_why(runner) for runner in runners if not runner.done]
        super().__init__("\n".join(["the graph is stuck; raise `depth` of the full edges", *lines]))


def _why(runner: StageRunner) -> str:
    full = [i.name for _, o in runner.outputs for i in o.queues if len(i.messages) >= i.depth]
    members = runner.join.members
    dry = [queue.name for queue in members if not queue.messages and queue.watermark != END]
    due = min((queue.messages[0].header.time for queue in members if queue.messages), default=None)
    if due is not None:
        dry += [name for sampled in runner.join.sampled for name in sampled.awaited(due)]
    return f"  {runner.name}: " + (f"full: {full}" if runner.blocked else f"waits for: {dry}")

"""Stages that leave a running graph: they are closed, with their taps and the messages that wait for them."""

from __future__ import annotations

from collections.abc import Collection

from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.runners.error_policy import StageError
from followspot.worker.runners.live_source import LiveSourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.taps.port_taps import taps_at


def close_leaving(runner: StageRunner) -> None:
    """Close a stage that leaves the graph; warn if it does not close, or if a tap reads its ports."""
    discard_sampled(runner.join, kept=())
    _end_taps(runner)
    try:
        runner.stop() if isinstance(runner, LiveSourceRunner) else runner.close()
    except StageError as error:
        runner.stage.context.warn(f"the stage left the graph and did not close: {error}")


def discard_sampled(join: Join, kept: Collection[InputQueue]) -> None:
    """Discard the messages at sampled inputs that wait for a firing that does not come.

    kept: queues that another join samples from now on, which keep their messages.
    """
    for sampled in join.sampled:
        for queue in sampled.queues:
            if queue not in kept:
                queue.clear(sampled.column)


def _end_taps(runner: StageRunner) -> None:
    """Close the taps of a stage that goes."""
    taps = list(taps_at(runner))
    if taps:
        runner.stage.context.warn("the stage left the graph: subscriptions and views of its ports end")
    for tap in taps:
        tap.detach()
        tap.close()

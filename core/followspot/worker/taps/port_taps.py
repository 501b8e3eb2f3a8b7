"""Taps at ports of a running graph: sinks that get every message, beside the graph.

A tap has no edge: it neither fires nor counts, and no stage waits for it. A tap that fails is removed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from followspot.context import Post
from followspot.control.tapping import Tapping
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports.firing import firings_of
from followspot.stage import Stage
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler
from followspot.worker.tap_point import TapPoint


class Tap:
    """One sink at one output port; a sink that raises EOFError has lost its receiver."""

    def __init__(self, tapping: Tapping, tapped: TapPoint, stage: Stage) -> None:
        self.tapping = tapping
        self._tapped = tapped
        self._stage = stage
        self._closed = False

    def __call__(self, message: Message) -> None:
        """Give the message to the sink; remove the tap if the sink raises."""
        try:
            self._stage.process(message)
        except Exception as error:
            self.detach()
            self.close()
            if not isinstance(error, EOFError):
                self._stage.context.warn(f"a tap failed and was taken away: {error!r}")

    def detach(self) -> None:
        """Remove the tap from its port. Safe from any thread."""
        self._tapped.untap(self)

    def close(self) -> None:
        """Close the sink, once; the tap must be detached and not at work."""
        if not self._closed:
            self._closed = True
            self._stage.close()


def taps_of(scheduler: Scheduler) -> Iterator[Tap]:
    """All taps at ports of a worker."""
    for runner in scheduler.runners:
        yield from taps_at(runner)


def taps_at(runner: StageRunner) -> Iterator[Tap]:
    """All taps at the ports of a stage, and at its journal."""
    for tapped in _tapped(runner).values():
        yield from (found for found in tapped.taps if isinstance(found, Tap))


def _tapped(runner: StageRunner) -> dict[str, TapPoint]:
    """The places of a stage that can be tapped, by name."""
    found: dict[str, TapPoint] = {f"{runner.name}.{port}": output for port, output in runner.outputs}
    return {**found, firings_of(runner.name): runner.journal}  # which has taps of its own


def tap(
    scheduler: Scheduler,
    tappings: Iterable[Tapping],
    post: Callable[[Tapping], Post | None] = lambda tapping: None,
) -> None:
    """Add the taps at ports of this worker that it does not have yet. Safe from any thread.

    post: the channel of a tap to observers on other hosts. Raises what sinks raise.
    """
    known = {name: (runner, one) for runner in scheduler.runners for name, one in _tapped(runner).items()}
    present = [found.tapping for found in taps_of(scheduler)]
    for tapping in tappings:
        runner, tapped = known.get(tapping.port, (None, None))
        if runner is None or tapped is None or tapping in present:
            continue
        context = replace(runner.stage.context, post=post(tapping))
        stage = load_stage(tapping.uses)(context, **tapping.params)
        stage.setup()
        tapped.tap(Tap(tapping, tapped, stage))

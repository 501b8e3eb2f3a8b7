"""Taps at ports of a running graph: sinks that get every message, beside the graph.

A tap has no edge: it neither fires nor counts, and no stage waits for it. A tap that fails is removed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from followspot.control.tapping import Tapping, check_taps
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.stage import Post, Stage
from followspot.worker.output_port import OutputPort
from followspot.worker.scheduler import Worker


class Tap:
    """One sink at one output port; a sink that raises EOFError has lost its receiver."""

    def __init__(self, tapping: Tapping, output: OutputPort, stage: Stage) -> None:
        self.tapping = tapping
        self._output = output
        self._stage = stage

    def __call__(self, message: Message) -> None:
        """Give the message to the sink; if it raises, the tap is removed."""
        try:
            self._stage.process(message)
        except Exception as error:
            self.close()
            if not isinstance(error, EOFError):
                self._stage.context.warn(f"a tap failed and was taken away: {error!r}")

    def close(self) -> None:
        """Remove the tap from its port, and close its sink."""
        self._output.untap(self)
        self._stage.close()


def close_taps(worker: Worker) -> None:
    """Close all taps of a worker that ends, so that their sinks complete what they do."""
    for runner in worker.runners:
        for _, output in runner.outputs:
            for found in output.taps:
                if isinstance(found, Tap):
                    found.close()


def tap(
    worker: Worker, tappings: Iterable[Tapping], post: Callable[[Tapping], Post | None] = lambda tapping: None
) -> None:
    """Add the taps at ports of this worker that it does not have yet. Safe from any thread.

    post: the channel of a tap to observers on other hosts. Raises what sinks raise.
    """
    outputs = {
        f"{runner.name}.{port}": (runner, output)
        for runner in worker.runners
        for port, output in runner.outputs
    }
    tappings = tuple(tappings)
    check_taps(tappings)
    for tapping in tappings:
        runner, output = outputs.get(tapping.port, (None, None))
        if runner is None or output is None or tapping in _tappings(output):
            continue
        context = replace(runner.stage.context, post=post(tapping))
        stage = load_stage(tapping.uses)(context, **tapping.params)
        stage.setup()
        output.tap(Tap(tapping, output, stage))


def _tappings(output: OutputPort) -> list[Tapping]:
    return [tap.tapping for tap in output.taps if isinstance(tap, Tap)]

"""Looking at ports of a graph that runs: sinks that are called with every message, beside the graph.

A tap has no edge: it neither fires nor counts, and nothing waits for it. One that fails is taken away.
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
    """One sink at one output port; one that raises EOFError has nobody left to tell."""

    def __init__(self, tapping: Tapping, output: OutputPort, stage: Stage) -> None:
        self.tapping = tapping
        self._output = output
        self._stage = stage

    def __call__(self, message: Message) -> None:
        """Hand the message to the sink; whatever it raises ends there."""
        try:
            self._stage.process(message)
        except Exception as error:
            self.close()
            if not isinstance(error, EOFError):
                self._stage.context.warn(f"a tap failed and was taken away: {error!r}")

    def close(self) -> None:
        """Look no more."""
        self._output.untap(self)
        self._stage.close()


def close_taps(worker: Worker) -> None:
    """Let every sink that looks at the worker's ports complete what it does; the last thing in its life."""
    for runner in worker.runners:
        for _, output in runner.outputs:
            for found in output.taps:
                if isinstance(found, Tap):
                    found.close()


def tap(
    worker: Worker, tappings: Iterable[Tapping], post: Callable[[Tapping], Post | None] = lambda tapping: None
) -> None:
    """Look at those of the ports that the worker has, once; safe from any thread. Raises what sinks raise.

    post: the way of a tap to those who look on from other hosts.
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

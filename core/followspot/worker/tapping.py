"""Taps at ports of a running graph: sinks that get every message, beside the graph.

A tap has no edge: it neither fires nor counts, and no stage waits for it. A tap that fails is removed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from followspot.control.tapping import Tapping
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
        self._closed = False

    def __call__(self, message: Message) -> None:
        """Give the message to the sink; if it raises, the tap is removed."""
        try:
            self._stage.process(message)
        except Exception as error:
            self.detach()
            self.close()
            if not isinstance(error, EOFError):
                self._stage.context.warn(f"a tap failed and was taken away: {error!r}")

    def detach(self) -> None:
        """Remove the tap from its port. Safe from any thread."""
        self._output.untap(self)

    def close(self) -> None:
        """Close the sink, once; the tap must be detached and not at work."""
        if not self._closed:
            self._closed = True
            self._stage.close()


def taps_of(worker: Worker) -> Iterator[Tap]:
    """All taps at ports of a worker."""
    for runner in worker.runners:
        for _, output in runner.outputs:
            yield from (found for found in output.taps if isinstance(found, Tap))


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
    present = [found.tapping for found in taps_of(worker)]
    for tapping in tappings:
        runner, output = outputs.get(tapping.port, (None, None))
        if runner is None or output is None or tapping in present:
            continue
        context = replace(runner.stage.context, post=post(tapping))
        stage = load_stage(tapping.uses)(context, **tapping.params)
        stage.setup()
        output.tap(Tap(tapping, output, stage))

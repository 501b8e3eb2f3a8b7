"""A stage with its join and its output ports: how watermarks, absences and ends pass through it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from followspot.graph.plan import ErrorPolicy
from followspot.stage import Stage
from followspot.transport.token import ABSENT, END, UNKNOWN
from followspot.worker.inputs.join import Join
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.stage_life import StageLife
from followspot.worker.runners.stage_outputs import StageOutputs


class StageStreams(StageLife):
    """Passes the watermark, absence and end of a stage's inputs on to its outputs.

    join: its inputs, empty for a source; outputs: by port.
    """

    def __init__(
        self,
        name: str,
        build: Callable[[], Stage],
        join: Join,
        outputs: Mapping[str, OutputPort],
        *,
        on_error: ErrorPolicy,
    ) -> None:
        """Build the stage. Raises StageError if that fails."""
        super().__init__(name, build, on_error)
        self.join = join
        self.outputs = StageOutputs(outputs)
        self.done = False
        """Whether the inputs have ended and the stage is closed."""
        self.absent = False
        """Whether the outputs have announced `ABSENT`."""
        self._passed = -END
        """The watermark that the outputs have announced, ns."""

    def finish(self) -> None:
        """Close the stage and end its outputs, for no input comes any more."""
        self.done = True
        self.close()
        self._discard_rest()
        self.outputs.end()

    def _discard_rest(self) -> None:
        """Discard messages after the last firing: feedback, or from a sender that was started again."""
        for sampled in self.join.sampled:
            sampled.discard_rest()
        for queue in self.join.members:
            queue.clear()

    def _idle(self) -> None:
        """Without a firing, pass the watermark on, or end with the last input."""
        watermark = self.join.watermark()
        if watermark == END:
            self.finish()
            return
        if watermark == ABSENT:
            self._pass_on_absence()
            return
        self.absent = False
        if watermark > self._passed:
            self._pass(watermark)
            self._announce(watermark)
        self.join.relieve_backpressure(watermark)

    def _following(self) -> int:
        """The watermark, ns, that the outputs can announce with what they send now; `UNKNOWN` if they cannot.

        A message takes the watermark along. The end and an absence travel by themselves.
        """
        watermark = self.join.watermark()
        if not self._passed < watermark < ABSENT:
            return UNKNOWN
        self._pass(watermark)
        return watermark

    def _pass(self, watermark: int) -> None:
        """Note that the outputs announce this watermark, ns: nothing earlier fires any more."""
        self._passed = watermark
        self.join.closed = max(self.join.closed, watermark - 1)

    def _announce(self, watermark: int) -> None:
        """Announce on all outputs that nothing earlier will come, ns."""
        self.outputs.advance(watermark)

    def _pass_on_absence(self) -> None:
        """Announce once that all inputs are absent, so that joins downstream do not wait for them."""
        if not self.absent:
            self.absent = True
            self.outputs.absent()

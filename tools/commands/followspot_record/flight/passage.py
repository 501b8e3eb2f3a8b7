"""The recorded firings of a stage again, in passages: from a checkpoint on, as long as nothing is missing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from followspot import Message
from followspot.errors import InputError
from followspot.graph.plan import Plan, PlannedStage
from followspot.library.repeat import (
    Checkpoint,
    Repetition,
    Unrepeatable,
    checkpoint_in,
    held_in,
    missing_in,
)
from followspot.messages import stamped
from followspot.plugins.registry import load_stage
from followspot.ports.firing import Firing, firings_of
from followspot.ports.signature import ports
from followspot.ports.specs import Giving
from followspot.wire import pack
from followspot_record.comparison import RunningComparison
from followspot_record.embedded import stage_mistakes
from followspot_record.flight.recorded_messages import RecordedMessages
from followspot_recording.decoding import decoded
from followspot_recording.recording import Recording
from followspot_recording.records import Recorded

NO_CHECKPOINT = "no checkpoint before them is recorded"


class Passage:
    """Firings that were repeated one after the other.

    first: capture time of the first one, ns; outputs: compared with what was recorded, by name.
    """

    def __init__(
        self, checkpoint: Checkpoint, first: int, outputs: Mapping[str, RunningComparison], gives: Giving
    ) -> None:
        self.checkpoint = checkpoint
        self.last = first - 1
        self._first = first
        self._outputs = outputs
        self._gives = gives
        self._sent: dict[str, int] = {}
        """Capture time of the newest message by output, ns."""
        for name, output in outputs.items():
            output.begin(first if gives == "later" else checkpoint.after.get(name, first))

    def send(self, output: str, message: Message) -> None:
        """Take a message that the stage sends."""
        header = message.header
        self._sent[output] = header.time
        if output in self._outputs:
            packed = pack(stamped(message, header._replace(entered=0)))
            self._outputs[output].take(Recorded(header.time, header.seq, memoryview(packed)))

    def end(self) -> bool:
        """Compare up to the last time that the firings decide alone; whether there were any firings."""
        for name, output in self._outputs.items():
            decided = self.last if self._gives in ("one", "later") else self._sent.get(name)
            if decided is not None:
                output.end(decided)
        return self.last >= self._first

    def goes_on(self, now: Checkpoint | None) -> bool:
        """Whether the same stage with the same parameters and edges works on; now: the newest checkpoint."""
        then = self.checkpoint
        return now is None or (then.uses, then.params, then.inputs, then.edges) == (
            now.uses,
            now.params,
            now.inputs,
            now.edges,
        )


class RepeatedStage:
    """Repeats one stage of a recording. types: of the messages, by port (STAGE.PORT).

    outputs: what it sent, compared with what was recorded, by name; repeated: whether any firing was;
    left_out: number of firings that were not, by reason.
    """

    def __init__(
        self,
        recording: Recording,
        plan: Plan,
        stage: PlannedStage,
        types: Mapping[str, type[Message]],
        out: Path,
    ) -> None:
        self.repeated = False
        kind = load_stage(stage.uses)
        self._gives = ports(kind).gives
        self.outputs = {
            port.name: RunningComparison(recording.ports[name], recording.messages(name))
            for port in ports(kind).outputs
            if (name := f"{stage.name}.{port.name}") in recording.ports
        }
        self.left_out: dict[str, int] = defaultdict(int)
        self._recording = recording
        self._plan = plan
        self._planned = stage
        self._types = types
        self._out = out
        self._messages = RecordedMessages(recording, types)
        self._passage: Passage | None = None
        self._stage: Repetition | None = None
        self._number = -1
        for firing in decoded(recording, firings_of(stage.name), Firing):
            try:
                self._repeat(firing)
            except Unrepeatable as error:
                self._end()
                self.left_out[str(error).partition("\n")[0]] += 1
        self._end()

    def _repeat(self, firing: Firing) -> None:
        """Repeat a firing, in the present passage or in a new one. Raises Unrepeatable."""
        checkpoint = checkpoint_in(firing)
        if checkpoint is not None:
            self._messages.add(dict(held_in(checkpoint, self._types)))
        gap, self._number = firing.header.seq != self._number + 1, firing.header.seq
        if self._passage is not None and (gap or not self._passage.goes_on(checkpoint)):
            self._end()
        using = self._passage.checkpoint if self._passage is not None else checkpoint
        if using is None:
            raise Unrepeatable(NO_CHECKPOINT)
        for port in missing_in(firing, using, self._messages.has):
            known = port in self._recording.ports
            raise Unrepeatable(f"{port} lacks messages" if known else f"{port} is not recorded")
        if self._passage is None or self._stage is None:
            self._passage = Passage(using, firing.header.time, self.outputs, self._gives)
            self._stage = self._restored(self._passage)
        self._stage.repeat(firing, self._messages.given)
        self._passage.last = firing.header.time

    def _restored(self, passage: Passage) -> Repetition:
        """The stage of a checkpoint. Raises Unrepeatable; InputError if it would write outside its folder."""
        checkpoint = passage.checkpoint
        planned = replace(self._planned, uses=checkpoint.uses, params=checkpoint.params)
        if mistakes := stage_mistakes(planned):
            raise InputError(mistakes)
        return Repetition(self._plan, planned, checkpoint, self._out, self._types, passage.send)

    def _end(self) -> None:
        """End the present passage."""
        if self._passage is not None:
            self.repeated |= self._passage.end()
        if self._stage is not None:
            self._stage.close()
        self._passage = self._stage = None

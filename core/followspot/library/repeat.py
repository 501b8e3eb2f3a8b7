"""Repeats the recorded firings of one stage: from a checkpoint on, with the messages that each took."""

from __future__ import annotations

import base64
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import pydantic

from followspot.context import Context
from followspot.control.checkpoint import state_from_data
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan, PlannedStage
from followspot.message_checks.room_fit import fit_check
from followspot.message_checks.sealing import seal
from followspot.messages import Header, InvalidMessage, Message
from followspot.plugins.registry import load_stage
from followspot.ports.firing import Firing
from followspot.ports.signature import ports
from followspot.ports.specs import InputSpec
from followspot.room import Room
from followspot.stage import Stage
from followspot.transport.codec import unpack
from followspot.worker.build import RUNNERS
from followspot.worker.inputs.recorded_join import RecordedFiring, RecordedJoin
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.deferred_runner import DeferredRunner
from followspot.worker.runners.error_policy import StageError
from followspot.worker.runners.lagged_runner import LaggedRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.stage_checkpoint import Checkpoint, InputRecord

__all__ = ["Checkpoint", "Given", "Repetition", "Unrepeatable", "checkpoint_in", "held_in", "missing_in"]

Given = Callable[[str, int], Message]
"""The recorded message of a port (STAGE.PORT) with this capture time, ns."""
Has = Callable[[str, int], bool]
"""Whether there is one."""
_LONGEST_ANSWER = 60.0
"""Seconds for an answer that comes later."""


class Unrepeatable(FollowspotError):
    """Firings cannot be repeated; the text says why."""


def checkpoint_in(firing: Firing) -> Checkpoint | None:
    """The checkpoint before a firing, None if it has none. Raises Unrepeatable."""
    if not len(firing.checkpoint):
        return None
    try:
        return Checkpoint.model_validate_json(firing.checkpoint.tobytes())
    except pydantic.ValidationError as error:
        raise Unrepeatable(f"a checkpoint is damaged: {error.errors()[0]['msg']}") from None


def held_in(
    checkpoint: Checkpoint, types: Mapping[str, type[Message]]
) -> Iterator[tuple[tuple[str, int], Message]]:
    """The messages that a checkpoint contains, by port and capture time, ns; only of ports in `types`.

    Raises Unrepeatable.
    """
    for row, packed in checkpoint.held:
        try:
            port = checkpoint.edges[row][0]
            if port not in types:
                continue
            message = unpack(base64.b64decode(packed, validate=True), types[port])
        except (InvalidMessage, LookupError, ValueError) as error:
            raise Unrepeatable(f"a checkpoint is damaged: {error}") from None
        if isinstance(message, Message):
            yield (port, message.header.time), message


class Repetition:
    """A stage from a checkpoint on.

    plan: of the run; stage: in it; out: folder for what the stage writes; types: of the messages, by port;
    sent: gets the name of an output and each message that is sent there.
    """

    def __init__(
        self,
        plan: Plan,
        stage: PlannedStage,
        checkpoint: Checkpoint,
        out: Path,
        types: Mapping[str, type[Message]],
        sent: Callable[[str, Message], None],
    ) -> None:
        """Build the stage and restore it. Raises Unrepeatable."""
        if checkpoint.problem:
            raise Unrepeatable(f"its state was not saved: {checkpoint.problem}")
        self._checkpoint = checkpoint
        self._types = types
        self._join = RecordedJoin()
        self._answered = threading.Event()
        context = Context(
            stage.name,
            plan.room_of(stage),
            stage.member,
            out,
            plan.seed,
            tuple(dict.fromkeys(types[port] for port, _ in checkpoint.edges if port in types)),
            pause=lambda seconds: True,
            resumed=True,
        )
        try:
            kind = load_stage(checkpoint.uses)
            self._inputs = ports(kind).inputs
            if len(self._inputs) != len(checkpoint.inputs):
                raise Unrepeatable(f"its checkpoint is of a stage with {len(checkpoint.inputs)} inputs")
            build = partial(kind, context, **checkpoint.params)
            self._runner = self._built(stage, kind, build, plan.room, sent)
            self._restore()
        except Exception as error:  # of a plugin
            raise Unrepeatable(f"it cannot be restored: {error}") from error

    def close(self) -> None:
        """Close the stage."""
        self._runner.retire(self._runner.stage)

    def repeat(self, firing: Firing, given: Given) -> None:
        """Repeat a firing; `given` has every message that it took. Raises Unrepeatable if the stage fails."""
        self._join.coming.append(self._recorded(firing, given))
        runner = self._runner
        try:
            while self._join.coming or runner.asks:
                self._answered.clear()
                runner.step()
                if runner.asks and not self._answered.wait(_LONGEST_ANSWER):
                    raise Unrepeatable("an answer does not come")
        except StageError as error:
            raise Unrepeatable(str(error)) from error

    def _built(
        self,
        stage: PlannedStage,
        kind: type[Stage],
        build: Callable[[], Stage],
        room: Room,
        sent: Callable[[str, Message], None],
    ) -> StageRunner:
        """The runner of the stage, with outputs whose messages go to `sent`."""
        found = ports(kind)
        outputs = {}
        for port in found.outputs:
            output = outputs[port.name] = OutputPort(port.type, memoryview(b""), lateness=0)
            output.unfit = fit_check(port.type, room, stage.camera)
            output.watermark = self._checkpoint.after.get(port.name, output.watermark)
            output.tap(partial(sent, port.name))
        runner = RUNNERS[found.gives](stage.name, 0, build, self._join, outputs, on_error=stage.on_error)
        if isinstance(runner, DeferredRunner):
            runner.answered = self._answered.set
        if isinstance(runner, LaggedRunner):
            runner.owe([Header(*owed) for owed in self._checkpoint.owed])
        return runner

    def _restore(self) -> None:
        """Set the stage up, with the state and the random numbers of the checkpoint."""
        stage, saved = self._runner.stage, self._checkpoint
        stage.context = replace(stage.context, resumed=True)
        self._runner.setup()
        if saved.state is not None:
            stage.restore(state_from_data(saved.state))
        if saved.random is not None:
            stage.rng.bit_generator.state = saved.random

    def _recorded(self, firing: Firing, given: Given) -> RecordedFiring:
        """The firing with the messages that it took."""
        checkpoint = self._checkpoint
        taken: list[list[Message]] = [[] for _ in checkpoint.inputs]
        for row, time in zip(firing.edge.tolist(), firing.captured.tolist(), strict=True):
            port, number = checkpoint.edges[row]
            taken[number].append(given(port, time))
        pairs = list(zip(checkpoint.inputs, taken, strict=True))
        arguments = [
            self._argument(spec, noted, found)
            for spec, (noted, found) in zip(self._inputs, pairs, strict=True)
        ]
        fired = [message for noted, found in pairs if noted.role == "member" for message in found]
        if not fired:
            raise Unrepeatable("a firing took no message that lets the stage fire")
        return RecordedFiring(firing.header.time, arguments, fired)

    def _argument(self, spec: InputSpec, noted: InputRecord, found: Sequence[Message]) -> object:
        """The argument for an input that took these messages."""
        if noted.joined:
            return tuple(found)
        if found:
            return found[0]
        return seal(self._empty(spec)) if noted.delayed else None

    def _empty(self, spec: InputSpec) -> Message:
        """The empty message that a delayed input gives before its first."""
        row = next(row for row, known in enumerate(self._inputs) if known == spec)
        port = next(port for port, number in self._checkpoint.edges if number == row)
        return self._types[port].empty()


def missing_in(firing: Firing, checkpoint: Checkpoint, has: Has) -> Iterable[str]:
    """The ports of which a firing took a message that is not recorded."""
    for row, time in zip(firing.edge.tolist(), firing.captured.tolist(), strict=True):
        port = checkpoint.edges[row][0] if 0 <= row < len(checkpoint.edges) else f"edge {row}"
        if not has(port, time):
            yield port

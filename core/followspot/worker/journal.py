"""The journal of a stage: which messages each firing takes, and checkpoints from which firings are repeated.

What only the run knows is in it: which messages came in time, were dropped or sampled, and which stage with
which parameters processed them. So no clock and no other stage is needed to repeat a stage.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator, Sequence
from threading import Lock
from typing import Any, Literal, NamedTuple, Protocol, Self

import numpy as np
import pydantic

from followspot.control.checkpoint import state_to_data
from followspot.firing import FIRINGS, Firing
from followspot.messages import Header, Message, stamped
from followspot.sealing import seal
from followspot.stage import Stage
from followspot.transport.codec import pack
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join, JoinInput
from followspot.worker.inputs.sampled_input import NearestInput, NewestInput, WindowInput
from followspot.worker.output_port import OutputPort

InputRole = Literal["member", "window", "sampled"]
_INTERVAL = 1_000_000_000
"""Capture time between two checkpoints, ns."""
_MOST_HELD = 1 << 20
"""Bytes of messages that a checkpoint contains; what does not fit must be in the recording by itself."""
_TAPPING = Lock()


class NotedInput(pydantic.BaseModel, frozen=True):
    """One input. joined: its argument is a tuple; delayed: it gives an empty message before the first."""

    role: InputRole
    joined: bool
    delayed: bool = False


class Checkpoint(pydantic.BaseModel, frozen=True, ser_json_inf_nan="constants"):
    """A stage between two firings.

    uses, params: what it is; inputs: in the order of `process`; edges: port that sends, and row of the input;
    remembers: whether the class has `state`; state, random: of the stage and of its random generator, in JSON
    types; problem: why the state cannot be saved; held: messages that wait at inputs or that sampled inputs
    hold, packed, in base64, each with the row of its edge; after: capture time before which nothing more is
    sent, ns, by output; owed: headers of earlier firings whose messages are yet to come (source, number, ns).
    """

    uses: str
    params: dict[str, Any]
    inputs: tuple[NotedInput, ...]
    edges: tuple[tuple[str, int], ...]
    remembers: bool
    state: Any = None
    random: Any = None
    problem: str = ""
    held: tuple[tuple[int, str], ...] = ()
    after: dict[str, int] = {}
    owed: tuple[tuple[str, int, int], ...] = ()

    @pydantic.model_validator(mode="after")
    def _check_edges(self) -> Self:
        if not all(0 <= row < len(self.inputs) for _, row in self.edges):
            raise ValueError("an edge leads to no input")
        return self


class FiringCounts(Protocol):
    """Counts of a stage's firings."""

    fired: int


class Journaled(Protocol):
    """The runner of a stage whose firings are noted."""

    name: str
    uses: str
    stage: Stage
    join: Join
    outputs: tuple[tuple[str, OutputPort], ...]

    @property
    def count(self) -> FiringCounts:
        """Counts of its firings."""

    @property
    def owed(self) -> Sequence[Header]:
        """Headers of earlier firings whose messages are yet to come."""


class _Note(NamedTuple):
    """What is noted before a firing takes its messages: those of joins and windows, by input."""

    checkpoint: bytes
    taken: Sequence[Sequence[tuple[int, int]]]


class Journal:
    """Notes the firings of a stage for its taps and for a recording; without both it costs nothing.

    output: leads to the recording; None without one.
    """

    def __init__(self, output: OutputPort | None = None) -> None:
        self.taps: tuple[Callable[[Message], None], ...] = ()
        self._output = output
        self._number = 0
        self._newest: int | None = None
        """Capture time of the newest checkpoint, ns; None if the next firing has one."""
        self._rows: dict[int, int] = {}
        """Row in the checkpoint's edges by the row of an edge in the ledger."""
        self._join: Join | None = None
        """The join at the newest checkpoint; a swap of the stage or of its edges replaces the join."""

    def tap(self, by: Callable[[Message], None]) -> None:
        """Call `by` with every firing from now on. Safe from any thread."""
        with _TAPPING:
            self._newest = None
            self.taps = (*self.taps, by)

    def untap(self, by: Callable[[Message], None]) -> None:
        """Call `by` no more. Safe from any thread."""
        with _TAPPING:
            self.taps = tuple(tap for tap in self.taps if tap is not by)

    @property
    def read(self) -> bool:
        """Whether anybody reads it."""
        return bool(self.taps) or self._output is not None

    def before(self, runner: Journaled, time: int) -> _Note:
        """Note what the firing at this time, ns, will take; call before it does."""
        newest, data = self._newest, b""
        if newest is None or runner.join is not self._join or abs(time - newest) >= _INTERVAL:
            self._newest, self._join = time, runner.join
            self._rows = {queue.row: row for row, (queue, _) in enumerate(_edges(runner.join))}
            data = checkpoint_of(runner).model_dump_json().encode()
        return _Note(data, [self._coming(port, runner.join, time) for port in runner.join.ports])

    def after(self, runner: Journaled, header: Header, note: _Note, arguments: Sequence[object]) -> None:
        """Give the firing to all that read the journal; call after it took its messages.

        header: of what it sends.
        """
        rows = [
            row
            for port, argument, taken in zip(runner.join.ports, arguments, note.taken, strict=True)
            for row in (self._sampled(port, argument) or taken)
        ]
        found = np.array(rows, "i8").reshape(-1, 2)
        firing = Firing(
            np.frombuffer(note.checkpoint, "u1"), found[:, 0].astype("i4"), np.ascontiguousarray(found[:, 1])
        )
        firing = stamped(seal(firing), header._replace(source=runner.name, seq=self._number))
        self._number += 1
        for tap in self.taps:
            tap(firing)
        if self._output is not None:
            self._output.send(firing, firing.header)

    def _coming(self, port: JoinInput, join: Join, time: int) -> list[tuple[int, int]]:
        """Edge and capture time of what a join's or a window's input gives, in its order."""
        if isinstance(port.sampled, WindowInput):
            found = [
                (self._rows[queue.row], message.header.time)
                for queue in port.sampled.queues
                for message in queue.messages
                if message.header.time <= time
            ]
            return sorted(found, key=lambda one: one[1])
        heads = [(queue, queue.messages[0].header.time) for queue in port.members if join.gives(queue, time)]
        return [(self._rows[queue.row], head) for queue, head in heads]

    def _sampled(self, port: JoinInput, argument: object) -> list[tuple[int, int]]:
        """Edge and capture time of the message that a sampled input gave, if it gave one that was sent."""
        if not isinstance(port.sampled, NewestInput | NearestInput) or not isinstance(argument, Message):
            return []
        if not argument.header.source:
            return []
        return [(self._rows[port.sampled.queue.row], argument.header.time)]


def checkpoint_of(runner: Journaled) -> Checkpoint:
    """The present checkpoint of a stage; call between two firings, in the worker's thread."""
    stage = runner.stage
    state, problem = _saved(runner)
    edges = list(_edges(runner.join))
    return Checkpoint(
        uses=runner.uses,
        params=stage.params.model_dump(mode="json"),
        inputs=tuple(map(_noted, runner.join.ports)),
        edges=tuple((queue.name.partition(" -> ")[0], row) for queue, row in edges),
        remembers=type(stage).state is not Stage.state,
        state=state,
        random=_random(stage),
        problem=problem,
        held=tuple(_held(runner.join)),
        after={port: output.watermark for port, output in runner.outputs if port != FIRINGS},
        owed=tuple(header[:3] for header in runner.owed),
    )


def _noted(port: JoinInput) -> NotedInput:
    if isinstance(port.sampled, WindowInput):
        return NotedInput(role="window", joined=True)
    delayed = isinstance(port.sampled, NewestInput) and port.sampled.delay > 0
    role: InputRole = "member" if port.sampled is None else "sampled"
    return NotedInput(role=role, joined=port.joined, delayed=delayed)


def _edges(join: Join) -> Iterator[tuple[InputQueue, int]]:
    """Each queue with the row of its input."""
    for row, port in enumerate(join.ports):
        for queue in (*port.members, *(port.sampled.queues if port.sampled is not None else ())):
            yield queue, row


def _saved(runner: Journaled) -> tuple[Any, str]:
    """The state in JSON types, or why it is none."""
    stage = runner.stage
    if stage.state_lacks and runner.count.fired:
        return None, f"it leaves out {stage.state_lacks}"
    try:
        return state_to_data(stage.state()), ""
    except Exception as error:  # of a plugin
        return None, f"{type(error).__name__}: {error}"


def _random(stage: Stage) -> Any:
    """The state of the random generator, None if the stage has not used it."""
    used: np.random.Generator | None = stage.__dict__.get("rng")
    return None if used is None else json.loads(json.dumps(used.bit_generator.state))


def _held(join: Join) -> Iterator[tuple[int, str]]:
    """The messages that wait, and those that sampled inputs hold, with the row of their edge."""
    size = 0
    for row, (queue, number) in enumerate(_edges(join)):
        sampled = join.ports[number].sampled
        held = sampled.held if isinstance(sampled, NewestInput | NearestInput) else None
        for message in (*([held] if held is not None and held.header.source else []), *queue.messages):
            packed = pack(message)
            if size + len(packed) <= _MOST_HELD:
                size += len(packed)
                yield row, base64.b64encode(packed).decode()

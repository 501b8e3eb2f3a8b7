"""A checkpoint of a stage between two firings, from which a recording repeats the firings after it."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Literal, Protocol, Self

import numpy as np
import pydantic

from followspot.control.checkpoint import state_to_data
from followspot.messages import Header
from followspot.ports.firing import FIRINGS
from followspot.stage import Stage
from followspot.transport.codec import pack
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import NearestInput, NewestInput, WindowInput
from followspot.worker.output_port import OutputPort

InputRole = Literal["member", "window", "sampled"]
_MOST_HELD = 1 << 20
"""Most bytes of messages in a checkpoint; further messages must be in the recording by themselves."""


class InputRecord(pydantic.BaseModel, frozen=True):
    """One input of the stage."""

    role: InputRole
    joined: bool
    """Whether its argument is a tuple."""
    delayed: bool = False
    """Whether it gives an empty message before the first."""


class Checkpoint(pydantic.BaseModel, frozen=True, ser_json_inf_nan="constants"):
    """A stage between two firings."""

    uses: str
    """The plugin stage."""
    params: dict[str, Any]
    inputs: tuple[InputRecord, ...]
    """Its inputs in the order of `process`."""
    edges: tuple[tuple[str, int], ...]
    """For each edge into the stage, the sending port and the row of the input in `inputs`."""
    remembers: bool
    """Whether the class has `state`."""
    state: Any = None
    """The stage's state in JSON types."""
    random: Any = None
    """The state of its random generator in JSON types; None if the stage has not used it."""
    problem: str = ""
    """Why the state cannot be saved, "" if it is saved."""
    held: tuple[tuple[int, str], ...] = ()
    """Messages that wait at inputs or that sampled inputs hold: row in `edges`, and the packed message in
    base64."""
    after: dict[str, int] = {}
    """Capture time before which nothing more is sent, ns, by output."""
    owed: tuple[tuple[str, int, int], ...] = ()
    """Headers of earlier firings whose messages are yet to come: source, number, capture time in ns."""

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

    @property
    def outputs(self) -> Iterable[tuple[str, OutputPort]]:
        """Its output ports by name."""

    @property
    def count(self) -> FiringCounts:
        """Counts of its firings."""

    @property
    def owed(self) -> Sequence[Header]:
        """Headers of earlier firings whose messages are yet to come."""


def checkpoint_of(runner: Journaled) -> Checkpoint:
    """The present checkpoint of a stage; call between two firings, in the worker's thread."""
    stage = runner.stage
    state, problem = _saved(runner)
    edges = list(edges_into(runner.join))
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


def _noted(port: JoinInput) -> InputRecord:
    if isinstance(port.sampled, WindowInput):
        return InputRecord(role="window", joined=True)
    delayed = isinstance(port.sampled, NewestInput) and port.sampled.delay > 0
    role: InputRole = "member" if port.sampled is None else "sampled"
    return InputRecord(role=role, joined=port.joined, delayed=delayed)


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
    for row, (queue, number) in enumerate(edges_into(join)):
        sampled = join.ports[number].sampled
        held = sampled.held if isinstance(sampled, NewestInput | NearestInput) else None
        for message in (*([held] if held is not None and held.header.source else []), *queue.messages):
            packed = pack(message)
            if size + len(packed) <= _MOST_HELD:
                size += len(packed)
                yield row, base64.b64encode(packed).decode()


def edges_into(join: Join) -> Iterator[tuple[InputQueue, int]]:
    """Each queue of a stage's inputs, with the row of its input."""
    for row, port in enumerate(join.ports):
        for queue in port.queues:
            yield queue, row

"""The ports of a stage as data: names, message types, and what each kind of input gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from followspot.messages import Message
from followspot.ports.firing import FIRINGS, Firing

InputKind = Literal["plain", "latest", "joined", "nearest", "window"]
Giving = Literal["one", "several", "later", "lagged"]
"""The kinds of results for a firing: one message each, several (`Outputs`), a later one (`Deferred`), or
messages for earlier firings (`Lagged`)."""
SEVERAL = ("joined", "window")
"""Kinds of inputs whose argument is a tuple of messages."""
ONE_OUTPUT = "out"
"""Name of the port of a stage that returns one message type."""


@dataclass(frozen=True)
class InputSpec:
    """One parameter of `process`. required: it has no default, so an edge must feed it."""

    name: str
    type: type[Message]
    kind: InputKind
    required: bool
    uniform: bool = False
    """True if all its messages are of one type, whichever it is: `Joined[M]` with a type variable M."""

    @property
    def fires(self) -> bool:
        """Whether a message of this input lets the stage fire; the other kinds are sampled."""
        return self.kind in ("plain", "joined")

    @property
    def several(self) -> bool:
        """Whether any number of edges may feed it, and its argument is a tuple."""
        return self.kind in SEVERAL


@dataclass(frozen=True)
class OutputSpec:
    """The result of `process`, or one field of it."""

    name: str
    type: type[Message]


@dataclass(frozen=True)
class Ports:
    """All ports of a stage; a source has no inputs, a sink no outputs."""

    inputs: tuple[InputSpec, ...]
    outputs: tuple[OutputSpec, ...]
    source: bool
    gives: Giving = "one"

    @property
    def any_name(self) -> bool:
        """True if a graph may give the input any name: there is one alone, and it takes any message."""
        return len(self.inputs) == 1 and self.inputs[0].type is Message

    def input(self, name: str) -> InputSpec | None:
        """The input that a graph means by this name."""
        return next((port for port in self.inputs if self.any_name or port.name == name), None)

    def output(self, name: str) -> OutputSpec | None:
        """The output of that name; None if there is none. `FIRINGS` is one of any stage with inputs."""
        if name == FIRINGS and self.inputs:
            return OutputSpec(FIRINGS, Firing)
        return next((port for port in self.outputs if port.name == name), None)


def accepts(wanted: type[Message], offered: type[Message]) -> bool:
    """True if an input of one type takes messages of another: the same type, or a subclass."""
    return issubclass(offered, wanted)

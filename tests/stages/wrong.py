"""Stages for tests that hand out, at one number, what they do not declare. Loaded with --plugin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from followspot import Field, Message, Source, Stage, StageParams, at

PERIOD = 10_000_000
"""Nanoseconds between two notes."""


class Note(Message):
    value: int


class Memo(Message):
    value: int


@dataclass(frozen=True)
class Sides:
    """What stages with two outputs return."""

    left: Note | None
    right: Note | None


@dataclass(frozen=True)
class LeftOnly:
    """An output is missing."""

    left: Note


class WrongParams(StageParams):
    """What to hand out, and when."""

    wrong: str = Field("", description="what is handed out instead of a note")
    at: int = Field(3, description="number at which", unit="1")
    count: int = Field(6, description="numbers of a source", unit="1")


def handed_out(params: Any, value: int, right: Any) -> Any:
    """What is right, or what is asked for instead at the number for that."""
    if value != params.at or not params.wrong:
        return right
    time = PERIOD * value
    return {
        "memo": Memo(value),
        "list": [Note(value)],
        "number": value,
        "late": at(time - PERIOD, Note(value)),
        "same time": at(time, Note(value)),
        "sides": Sides(Note(value), Note(value)),
        "left only": LeftOnly(Note(value)),
        "wrong side": Sides(Note(value), at(time, Memo(value))),  # type: ignore[arg-type]
        "timed side": Sides(Note(value), at(time, Note(value))),
        "two times": Sides(at(time, Note(value)), at(time + 1, Note(value))),
        "no sides": Sides(None, None),
        "bare": Note(value),
        "none": None,
    }[params.wrong]


class Count(Stage):
    """Counts from 0."""

    Params = WrongParams
    params: WrongParams

    def process(self) -> Source[Note]:
        for n in range(self.params.count):
            yield handed_out(self.params, n, at(n * PERIOD, Note(n), seq=n))


class Live(Stage):
    """Counts from 0, like a device without a clock."""

    Params = WrongParams
    params: WrongParams
    live: ClassVar[bool] = True

    def process(self) -> Source[Note]:
        for n in range(self.params.count):
            yield handed_out(self.params, n, Note(n))


class CountBoth(Stage):
    """Counts from 0 on two ports; the time stands on one of them."""

    Params = WrongParams
    params: WrongParams

    def process(self) -> Source[Sides]:
        for n in range(self.params.count):
            yield handed_out(self.params, n, Sides(at(n * PERIOD, Note(n), seq=n), Note(n)))


class NoGenerator(Stage):
    """Says that it is a source, and yields nothing."""

    def process(self) -> Source[Note]:
        return None  # type: ignore[return-value]


class Pass(Stage):
    """Hands its input on; works together with those that are alike."""

    Params = WrongParams
    params: WrongParams

    def process(self, note: Note) -> Note:
        return handed_out(self.params, note.value, note)  # type: ignore[no-any-return]

    @classmethod
    def process_together(cls, stages: Sequence[Self], inputs: Sequence[tuple[Note]]) -> list[Note]:
        return [stage.process(*arguments) for stage, arguments in zip(stages, inputs, strict=True)]


class Split(Stage):
    """Hands its input on through two ports."""

    Params = WrongParams
    params: WrongParams

    def process(self, note: Note) -> Sides:
        return handed_out(self.params, note.value, Sides(note, note))  # type: ignore[no-any-return]


class Collect(Stage):
    """Keeps what comes; declares that it returns nothing."""

    Params = WrongParams
    params: WrongParams
    got: ClassVar[list[tuple[str, int, int]]] = []
    """Name of the stage, value, capture time in ns; tests clear it."""

    def process(self, note: Note) -> None:
        self.got.append((self.context.name, note.value, note.header.time))
        return handed_out(self.params, note.value, None)  # type: ignore[no-any-return]

"""Whatever a stage raises or returns, its run ends with one error that names the stage and the reason."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

import followspot as fs
from followspot import Message, Outputs, Source, Stage, at


class Note(Message):
    number: int


class Unreadable(Exception):
    """An error whose text cannot be read."""

    def __str__(self) -> str:
        raise ValueError("no text")


class Give(Stage):
    """Gives ten notes."""

    def process(self) -> Source[Note]:
        yield from (at(n, Note(n)) for n in range(10))


class Nothing(Stage):
    """A source that forgets to yield."""

    def process(self) -> Source[Note]:
        return None  # type: ignore[return-value]


class Unpack(Stage):
    """Returns the note itself."""

    def process(self, note: Note) -> Outputs[Note]:
        return note  # type: ignore[return-value]


def raising(error: BaseException) -> type[Stage]:
    """A stage that raises this at the third message."""

    class Fall(Stage):
        """Falls."""

        def process(self, note: Note) -> Note:
            if note.number == 3:
                raise error
            return note

    return Fall


def falling(error: BaseException) -> type[Stage]:
    """A live source that raises this after a message."""

    class Device(Stage):
        """Falls."""

        live = True

        def process(self) -> Source[Note]:
            yield Note(0)
            raise error

    return Device


def failure(graph: fs.Graph, out: Path) -> str:
    """The first line of what a run fails with."""
    with pytest.raises(fs.RunFailed) as caught, fs.run(graph, out=out) as run:
        run.wait()
    return str(caught.value).splitlines()[0]


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (KeyboardInterrupt(), "KeyboardInterrupt: "),
        (GeneratorExit(), "GeneratorExit: "),
        (asyncio.CancelledError("the loop ended"), "CancelledError: the loop ended"),
        (Unreadable(), "Unreadable: its text cannot be read"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_an_error_of_any_kind_is_one_of_its_stage(tmp_path: Path, error: BaseException, said: str) -> None:
    graph = fs.Graph("falls")
    graph.add("b", raising(error), note=graph.add("a", Give))
    assert failure(graph, tmp_path) == f"stage b failed at a#3, 0.000000 s: {said}"
    live = fs.Graph("live")
    live.add("a", falling(error))
    assert failure(live, tmp_path).endswith(said)


def test_one_message_where_several_belong_is_told(tmp_path: Path) -> None:
    said = "instead of several messages: yield them, or return a list"
    graph = fs.Graph("nothing")
    graph.add("a", Nothing)
    assert failure(graph, tmp_path).endswith(f"WrongOutput: returned None {said}")
    graph = fs.Graph("one")
    graph.add("b", Unpack, note=graph.add("a", Give))
    assert failure(graph, tmp_path).endswith(f"WrongOutput: returned a Note {said}")

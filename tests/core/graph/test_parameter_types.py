"""A value of another type is told in the words of files, not in those of Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from followspot import Field, Source, Stage, StageParams
from followspot.errors import InputError
from followspot.library.graph import Graph
from followspot.tracking import Tracks


class Typed(Stage):
    """Parameters of several types."""

    class Params(StageParams):
        size: float = Field(1.0, unit="m", description="a number")
        count: int = Field(1, unit="1", description="a whole number")
        loud: bool = Field(False, description="true or false")
        path: Path = Field(Path("a.csv"), description="a path")
        names: tuple[str, ...] = Field((), description="a list")
        marks: dict[str, float] = Field({}, unit="m", description="a mapping")
        text: str = Field("", description="text")

    def process(self) -> Source[Tracks]:
        yield from ()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"size": "high"}, "cannot be 'high': it must be a number"),
        ({"size": None}, "cannot be nothing: it must be a number"),
        ({"size": [1.0]}, "cannot be this: it must be a number"),
        ({"count": "many"}, "cannot be 'many': it must be a whole number"),
        ({"count": 1.5}, "cannot be 1.5: it must be a whole number"),
        ({"loud": "perhaps"}, "cannot be 'perhaps': it must be true or false"),
        ({"path": None}, "cannot be nothing: it must be a path"),
        ({"names": 5}, "cannot be 5: it must be a list"),
        ({"marks": 5}, "cannot be 5: it must be a mapping of keys to values"),
        ({"text": 5}, "cannot be 5: it must be text"),
    ],
)
def test_a_value_of_another_type_is_told_in_the_words_of_files(given: dict[str, Any], said: str) -> None:
    graph = Graph("g")
    graph.add("typed", Typed, **given)
    with pytest.raises(InputError) as told:
        graph.plan()
    assert any(said in mistake.text for mistake in told.value.mistakes)

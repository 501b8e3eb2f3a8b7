"""Defaults that a class makes anew, and those that cannot travel to a worker."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot import Field, Stage, StageParams
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.plugins.description import describe
from followspot.tracking import Tracks

PLUGIN = """
from followspot import Field, Source, Stage, StageParams
from followspot.tracking import Tracks


class Calling(Stage):
    \"\"\"Takes a function.\"\"\"

    class Params(StageParams):
        height: float = Field(1.0, unit="m", description="a height")
        key: object = Field(default_factory=lambda: abs, description="what to call")

    def process(self) -> Source[Tracks]:
        yield from ()
"""


class Named(Stage):
    """Names of things."""

    class Params(StageParams):
        names: list[str] = Field(default_factory=lambda: ["red"], description="names")

    def process(self, tracks: Tracks) -> Tracks:
        return tracks


def test_a_parameter_that_cannot_travel_is_refused_at_its_stage(tmp_path: Path) -> None:
    plugin, graph = tmp_path / "own.py", tmp_path / "graph.yaml"
    plugin.write_text(PLUGIN)
    (tmp_path / "room.yaml").write_text("room: empty\n")
    graph.write_text("graph: g\nroom: room.yaml\nstages:\n  call: {uses: own.calling}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(graph, plugin_files=[str(plugin)])
    assert str(caught.value).startswith(
        f'{graph}:4:16: "key" of stage "call" (own.calling) cannot be written as JSON'
    )


def test_a_default_that_is_made_anew_is_described() -> None:
    assert describe("own.named", Named)["parameters"][0]["default"] == ["red"]

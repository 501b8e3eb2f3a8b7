"""Limits between parameters: no `minimum_x` is more than `maximum_x`."""

from __future__ import annotations

from pathlib import Path

import pydantic
import pytest

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.stage import StageParams
from followspot.stage_params import Field

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


class Params(StageParams):
    """Two that belong together, and one beside them."""

    minimum_area: float = Field(0.3, unit="1", description="smallest; raising it rejects more")
    maximum_area: float | None = Field(1.5, unit="1", description="largest; raising it accepts more")
    minimum_votes: int = Field(3, unit="1", description="fewest; raising it rejects more")


def test_a_least_value_is_no_more_than_its_greatest() -> None:
    assert Params(minimum_area=1.5).maximum_area == 1.5
    assert Params(minimum_area=7, maximum_area=None).minimum_area == 7  # no limit
    assert Params(minimum_votes=9).minimum_votes == 9
    with pytest.raises(pydantic.ValidationError, match=r"minimum_area 7 is more than maximum_area 1\.5"):
        Params(minimum_area=7)


def test_a_graph_is_told_where_and_once() -> None:
    with pytest.raises(InputError) as caught:
        compile_graph(GRAPH, overrides=["color.minimum_area=7"])
    text = str(caught.value)
    assert text.startswith("--set:1:20: ")
    assert "minimum_area 7 is more than maximum_area 1.5" in text
    assert text.count("is more than") == 1

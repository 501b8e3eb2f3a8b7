"""True and false are no numbers: a parameter that takes numbers refuses them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import pydantic
import pytest

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.stage import StageParams
from followspot.stage_params import Field

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


class Params(StageParams):
    """Numbers, alone and within others, and those that take more than numbers."""

    share: float = Field(0.3, unit="1", description="a number")
    count: int | None = Field(None, unit="1", description="a whole number, or none")
    point: tuple[float, float] = Field((0.0, 1.0), unit="m", description="a point")
    sizes: dict[str, Annotated[float, pydantic.Field(gt=0)]] = Field({}, unit="m", description="by name")
    either: bool | float = Field(0.5, unit="1", description="a number, or whether at all")
    fast: bool = Field(True, description="a switch")
    any_one: Any = Field(None, description="anything")


@pytest.mark.parametrize(
    "values", [{"share": True}, {"count": False}, {"point": [1.0, True]}, {"sizes": {"a": True}}]
)
def test_a_switch_is_refused_where_a_number_is_meant(values: dict[str, Any]) -> None:
    with pytest.raises(pydantic.ValidationError, match="it must be a number, not true or false"):
        Params.model_validate(values)


def test_a_switch_is_taken_where_one_is_meant() -> None:
    params = Params(either=True, fast=False, any_one=[True], count=1, sizes={"a": 1})
    assert (params.either, params.fast, params.any_one, params.count) == (True, False, [True], 1)


@pytest.mark.parametrize("value", ["true", "no", "false"])
def test_a_graph_is_told_where(value: str) -> None:
    with pytest.raises(InputError) as caught:
        compile_graph(GRAPH, overrides=[f"color.similarity={value}"])
    assert str(caught.value).startswith("--set:1:18: ")

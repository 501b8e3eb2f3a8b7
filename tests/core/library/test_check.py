"""`check`: mistakes in a graph and its options are data, before anything starts."""

from __future__ import annotations

import re
from typing import Any

import pytest
from tests.core.library.scripts import GRAPH

import followspot as fs


def test_mistakes_are_data_with_their_places() -> None:
    (mistake,) = fs.check(GRAPH, set={"fuse.steps": 3})
    assert 'no parameter "steps"' in mistake.text
    assert 'did you mean "maximum_iterations"' in mistake.remedy


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"edges": "rings"}, 'edges is .rings.\\n    did you mean "ring"'),
        ({"seed": -3}, r"seed is -3\n    give a whole number from 0 to 9223372036854775807"),
        ({"seed": 1 << 63}, "seed is 9223372036854775808"),
        ({"seed": "7"}, "seed is '7'"),
    ],
)
def test_an_option_that_cannot_be_is_refused_with_what_can(option: dict[str, Any], said: str) -> None:
    (mistake,) = fs.check(GRAPH, **option)
    assert re.match(said, str(mistake))

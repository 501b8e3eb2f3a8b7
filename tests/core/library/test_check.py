"""`check`: mistakes in a graph and its options are data, before anything starts."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import pytest
from tests.core.library.scripts import GRAPH, composed

import followspot as fs
from followspot.tracking import Tracks


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


class Collecting(fs.Stage):
    """Collects in its class, where all instances and runs of a notebook share what they find."""

    seen: list[int] = []  # noqa: RUF012
    names: Mapping[str, int] = {"red": 1}

    def process(self, tracks: Tracks) -> None:
        self.seen.append(tracks.header.seq)


def test_a_container_in_the_class_of_a_stage_is_warned_of() -> None:
    graph = composed()
    graph.add("collect", Collecting, tracks=graph.port("low"))
    (mistake,) = fs.check(graph)
    assert mistake.warning
    assert mistake.text == "here.collecting keeps the list seen in its class, for all its instances and runs"
    assert mistake.remedy == "make it in setup(self): self.seen = list()"

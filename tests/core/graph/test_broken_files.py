"""Each mistake is found alone, at its line and column, with words that say what is wrong and what to do."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from tests.core.graph.broken_case import Broken
from tests.core.graph.broken_graphs import ENVELOPE, EXPANSION, SYNTAX
from tests.core.graph.broken_rooms import PLACEMENTS, ROOMS
from tests.core.graph.broken_stages import PARAMETERS, PORTS
from tests.core.graph.files import GRAPH, PLACEMENT, ROOM, TOY, write

from followspot.errors import InputError
from followspot.graph.compile import compile_graph

ALL = [*SYNTAX, *ENVELOPE, *EXPANSION, *PORTS, *PARAMETERS, *ROOMS, *PLACEMENTS]
_GOOD = {"graph": GRAPH, "room": ROOM, "placement": PLACEMENT}


def test_the_files_that_are_broken_here_are_good_before(tmp_path: Path) -> None:
    plan = compile_graph(write(tmp_path), placement=tmp_path / "placement.yaml", plugin_files=[TOY])
    assert [worker.name for worker in plan.workers] == ["main", "left", "right"]


def test_there_are_more_than_45_distinct_cases() -> None:
    assert len({(case.file, case.old, case.new) for case in ALL}) == len(ALL) > 45


@pytest.mark.parametrize(
    "case", ALL, ids=[f"{n:03}-{re.sub(r'[^a-z]+', '-', c.text)}" for n, c in enumerate(ALL)]
)
def test_mistake_is_reported_at_its_place(case: Broken, tmp_path: Path) -> None:
    good = _GOOD[case.file]
    assert case.old in good
    marked = good.replace(case.old, case.new, 1)
    before, _, after = marked.partition("¦")
    graph = write(tmp_path, **{case.file: before + after})
    with pytest.raises(InputError) as caught:
        compile_graph(graph, placement=tmp_path / "placement.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert case.text in mistake.text
    assert case.remedy in mistake.remedy
    assert mistake.place is not None
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    assert (Path(mistake.place.file).stem, mistake.place.line, mistake.place.column) == (
        case.file,
        line,
        column,
    )

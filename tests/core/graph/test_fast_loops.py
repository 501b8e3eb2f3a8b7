"""Joins in a loop that get messages more often than their tolerances let them fire."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import write

import followspot as fs
from followspot.errors import Mistake

STAGES = Path(__file__).parents[2] / "stages/rates.py"
GRAPH = """graph: loop
stages:
  one:    {uses: rates.device, with: {hz: RATE}}
  two:    {uses: rates.device, with: {hz: RATE}}
  seek:   {uses: rates.mix, in: {frame: one, latest: LATEST}}
  meet:   {uses: rates.mix, in: {frame: seek, other: two}}
  refine: {uses: rates.mix, in: {frame: meet, other: two}}
  save:   {uses: rates.write, in: {readings: gather}}
  gather: {uses: rates.near, in: {frame: refine, reading: two}}
"""


def told(folder: Path, rate: int, latest: str) -> list[Mistake]:
    text = GRAPH.replace("RATE", str(rate)).replace("LATEST", latest)
    return fs.check(write(folder, graph=text), plugin_files=[STAGES])


@pytest.mark.parametrize(("rate", "refused"), [(100, False), (124, False), (130, True), (1000, True)])
def test_a_loop_whose_joins_close_for_longer_than_its_messages_are_apart_is_refused(
    tmp_path: Path, rate: int, refused: bool
) -> None:
    found = told(tmp_path, rate, "{from: refine, delay: 1}")
    assert [not mistake.warning for mistake in found] == [True] * refused


def test_the_mistake_names_the_joins_and_a_tolerance_that_mends_it(tmp_path: Path) -> None:
    (mistake,) = told(tmp_path, 1000, "{from: refine, delay: 1}")
    assert mistake.text == (
        '1000 messages/s reach stage "refine", which is in a loop, but by the tolerances of the joins meet, '
        "refine it fires once in 8 ms at most"
    )
    assert 'set={"meet.tolerance": 0.00045, "refine.tolerance": 0.00045}' in mistake.remedy
    assert mistake.place is not None
    assert mistake.place.line == 7
    mended = {"meet.tolerance": 0.00045, "refine.tolerance": 0.00045}
    assert fs.check(tmp_path / "graph.yaml", set=mended, plugin_files=[STAGES]) == []


def test_without_a_loop_such_joins_may_leave_messages_out(tmp_path: Path) -> None:
    assert told(tmp_path, 1000, "one") == []

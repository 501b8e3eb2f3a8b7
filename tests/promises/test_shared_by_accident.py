"""What stages that share a worker could do to each other changes no result: a placement would, too."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.integration.running import Finished, run, write_graph

STAGES = '''
import numpy as np

import followspot as fs
from followspot import Array, Source, Stage, at, column

{top}


class Numbers(fs.Message):
    numbers: Array = column("N")


class Give(Stage):
    """Gives five messages, each of more bytes than travel beside shared memory."""

    def process(self) -> Source[Numbers]:
        yield from (at(n, Numbers(np.full(1000, -400.0 * n))) for n in range(5))


class Small(Stage):
    """Makes numbers so small that the last ones are 0."""

    def process(self, numbers: Numbers) -> Numbers:
        return Numbers(np.exp(numbers.numbers))


class Stranger(Stage):
    """Does something to what it shares with the others."""

    def setup(self) -> None:
        {setup}

    def process(self, numbers: Numbers) -> Numbers:
        {process}
        return numbers
'''
GRAPH = """
give:     {uses: shared.give}
stranger: {uses: shared.stranger, in: {numbers: give}}
small:    {uses: shared.small, in: {numbers: give}}
save:     {uses: sinks.csv, in: {numbers: small}, with: {path: numbers.csv}}
"""
OPTIONS = [(), ("--placement", "stage")]


def ended(folder: Path, options: tuple[str, ...], **parts: str) -> Finished:
    """A run with such a stranger beside two other stages."""
    folder.mkdir()
    given = {"top": "", "setup": "pass", "process": "pass", **parts}
    (folder / "shared.py").write_text(STAGES.format(**given))
    return run(write_graph(folder, GRAPH), "--plugin", str(folder / "shared.py"), *options)


@pytest.mark.parametrize("options", OPTIONS, ids=["one", "stages"])
@pytest.mark.parametrize("place", ["setup", "top"])
def test_how_a_stage_wants_numpy_to_treat_errors_counts_for_no_other_stage(
    tmp_path: Path, options: tuple[str, ...], place: str
) -> None:
    expected = ended(tmp_path / "plain", ())
    changed = ended(tmp_path / "changed", options, **{place: 'np.seterr(all="raise")'})
    assert (expected.code, changed.code) == (0, 0), changed.errors
    assert changed.lines("numbers.csv") == expected.lines("numbers.csv")
    assert len(expected.lines("numbers.csv")) > 5000
    told = [line for line in changed.summary["warnings"] if "stranger: its setup called np.seterr" in line]
    assert len(told) == (place == "setup")


@pytest.mark.parametrize("options", OPTIONS, ids=["one", "stages"])
def test_a_stage_that_makes_its_input_writeable_fails(tmp_path: Path, options: tuple[str, ...]) -> None:
    failed = ended(tmp_path / "writes", options, process="numbers.numbers.setflags(write=1)")
    assert failed.code == 1
    assert "stage stranger failed" in failed.errors
    assert "writeable" in failed.errors.lower()
    assert options or "change a copy of it, numbers.copy()" in failed.errors

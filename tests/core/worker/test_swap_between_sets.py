"""A replay changes its graph between sets of messages that belong together: none is torn or left behind."""

from __future__ import annotations

from pathlib import Path

import pytest

import followspot as fs

SETS = Path(__file__).parents[2] / "stages" / "sets.py"
WHOLE = """
graph: whole
stages:
  a:    {uses: sets.count}
  b:    {uses: sets.count, with: {shift: 3000000}}
  hall: {graph: pair.yaml, in: {one: a, two: b}}
  last: {uses: sets.pass, in: {note: hall.notes}}
"""
INSIDE = """
graph: inside
inputs: {{one: one.note, two: two.note}}
outputs: {{notes: {name}}}
stages:
  one: {{uses: sets.pass}}
  two: {{uses: sets.pass}}
"""
SET = "  {name}: {{uses: sets.{uses}, in: {inputs}}}\n"
JOINED = "{notes: [one, two]}"


def write(folder: Path, name: str, *stages: tuple[str, str, str]) -> Path:
    """A file of these stages (name, plugin, inputs), of which the last gives the output."""
    path = folder / f"{name}.yaml"
    lines = [SET.format(name=one, uses=uses, inputs=inputs) for one, uses, inputs in stages]
    path.write_text(INSIDE.format(name=stages[-1][0]) + "".join(lines))
    return path


@pytest.mark.parametrize(
    "other",
    [
        [("another", "pair", JOINED)],
        [("several", "several", JOINED)],
        [("near", "near", "{note: one, other: two}")],
        [("set", "pair", JOINED), ("late", "late", "{note: set}")],
    ],
    ids=["join", "outputs", "nearest", "lagged"],
)
def test_sets_of_shifted_sources_stay_whole(tmp_path: Path, other: list[tuple[str, str, str]]) -> None:
    files = {False: write(tmp_path, "pair", ("pair", "pair", JOINED)), True: write(tmp_path, "other", *other)}
    graph = tmp_path / "whole.yaml"
    graph.write_text(WHOLE)
    seen: list[tuple[int, int]] = []
    with fs.run(graph, plugin_files=[SETS], ports=["last"], out=tmp_path / "out") as run:
        for change in range(5):
            while len(seen) < 20 * change + 20:
                note = next(run["last"])
                seen.append((note.number, note.members))
            if change < 4:
                run.swap("hall", str(files[change % 2 == 0]))
    assert seen == [(number, 2) for number in range(100)]
    assert run.report.ok
    assert not any(row["lost"] for row in run.report.ledger)

"""A replay changes its graph between sets of messages that belong together: none is torn or left behind."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

import followspot as fs
from followspot.worker.change import hot_swap
from followspot.worker.rest import Rest
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.sources import Sources

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


DEVICES = """
graph: devices
stages:
  a:    {uses: sets.device, depth: 4, with: {first: 2}}
  b:    {uses: sets.device, depth: 4}
  hall: {graph: pair.yaml, in: {one: a, two: b}}
  last: {uses: sets.pass, in: {note: hall.notes}}
"""


def test_a_live_set_that_is_being_taken_stays_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One device has given its note of the second set, the other gives it while the swap waits for it."""
    out = tmp_path / "out"
    reached = Rest.reached

    def looked(rest: Rest, sources: Sources, runners: Iterable[StageRunner]) -> bool:
        """Whether the worker rests; the missing note comes once it has been found not to."""
        found = reached(rest, sources, runners)
        (out / "go1").touch()
        return found

    monkeypatch.setattr(Rest, "reached", looked)
    monkeypatch.setattr(hot_swap, "_LIVE_REST_TIMEOUT", 600.0)
    patient = f"{JOINED}, deadline: 600"
    write(tmp_path, "pair", ("pair", "pair", patient))
    other = write(tmp_path, "other", ("other", "pair", patient))
    graph = tmp_path / "devices.yaml"
    graph.write_text(DEVICES)
    with fs.run(graph, plugin_files=[SETS], ports=["a", "last"], out=out) as run:
        early = [next(run["a"]).number for _ in range(2)]
        seen = [next(run["last"])]
        run.swap("hall", str(other))
        for number in (1, 2, 3):
            (out / f"go{number}").touch()
        seen += run["last"]
        assert [*early, *(note.number for note in run["a"])] == [0, 1, 2, 3]
    assert [(note.number, note.members) for note in seen] == [(0, 2), (1, 2), (2, 2), (3, 2)]
    assert not run.report.warnings
    delivered = {(row["from"], row["to"]): row["delivered"] for row in run.report.ledger}
    changed = {
        edge: count
        for edge, count in delivered.items()
        if not {"hall/pair", "hall/other"}.isdisjoint(map(stage_of, edge))
    }
    assert set(changed.values()) == {2}, "to the stage that went, and to the one that came"
    assert {count for edge, count in delivered.items() if edge not in changed} == {4}


def stage_of(port: str) -> str:
    """The stage of STAGE.PORT."""
    return port.rpartition(".")[0]


FEEDBACK = """
graph: feedback
inputs: {{one: [last.note, near.note]}}
outputs: {{notes: {name}}}
stages:
  {name}: {{uses: sets.recent, in: {{note: last, before: {{from: near, delay: 1}}, beside: near}}}}
  near:   {{uses: sets.recent, in: {{before: {{from: {name}, delay: 1}}}}}}
  last:   {{uses: sets.pass}}
"""


def test_what_no_firing_was_to_get_is_not_lost(tmp_path: Path) -> None:
    """One message of each feedback edge that leaves waits for the next firing."""
    files = [tmp_path / f"{name}.yaml" for name in ("pair", "other")]
    for file in files:
        file.write_text(FEEDBACK.format(name=file.stem))
    graph = tmp_path / "whole.yaml"
    graph.write_text(WHOLE.replace(", two: b", "").replace("  b: ", "  # b: "))
    with fs.run(graph, plugin_files=[SETS], ports=["last"], out=tmp_path / "out", frames=100) as run:
        for _ in range(20):
            next(run["last"])
        run.swap("hall", str(files[1]))
        assert [note.number for note in run["last"]] == list(range(20, 100))
    former = [row for row in run.report.ledger if "hall/pair" in str(row)]
    assert former
    assert not any(row["lost"] for row in run.report.ledger)

"""`check --strict`: all that can make two runs differ is a mistake at its place, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.errors import InputError
from followspot.graph.compile import compile_graph

ROOT = Path(__file__).parents[3]
TICKS = str(ROOT / "tests" / "stages" / "ticks.py")
DICE = """
from followspot import Field, Source, Stage, StageParams
from followspot.tracking import Tracks

class Roll(Stage):
    class Params(StageParams):
        seed: int | None = Field(None, description="of the dice", unit="1")

    def process(self) -> Source[Tracks]:
        yield from ()
"""
REPLAY = """
graph: g
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.add, in: {number: {from: a, policy: latest}}}
  c: {uses: ticks.sum, in: {numbers: [a, b]}, deadline: 0.5}
  d: {uses: ticks.accumulate, in: {number: c, before: a}}
  e: {uses: ticks.write, in: {number: d}}
"""
LIVE = REPLAY.replace("ticks.count", "ticks.live")


def strict(folder: Path, text: str, *plugins: str) -> list[tuple[int, int, str, str]]:
    """Line, column, text and remedy of each mistake."""
    (folder / "g.yaml").write_text(text)
    try:
        compile_graph(folder / "g.yaml", plugin_files=[TICKS, *plugins], strict=True)
    except InputError as error:
        return [(m.place.line, m.place.column, m.text, m.remedy) for m in error.mistakes if m.place]
    return []


def test_a_replay_is_strict_whatever_would_matter_in_a_live_run(tmp_path: Path) -> None:
    assert strict(tmp_path, REPLAY) == []


def test_a_live_run_has_all_its_reasons_at_their_places(tmp_path: Path) -> None:
    assert strict(tmp_path, LIVE) == [
        (4, 13, 'stage "a" (ticks.live) is live: nothing comes twice', "record the run and replay it"),
        (5, 55, 'input "number" loses messages if its stage is slow', "policy: block"),
        (6, 57, 'stage "c" goes on without what is 0.5 s late', "replay the run: it waits for all"),
        (
            7,
            55,
            'input "before" of stage "d" takes the newest message that has arrived',
            "replay the run, or delay it: {from: a, delay: 1}",
        ),
    ]
    compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS])


def test_a_sampled_cycle_of_a_live_run_is_named_once(tmp_path: Path) -> None:
    found = strict(tmp_path, LIVE.replace("before: a", "before: d"))
    assert [text for line, _, text, _ in found if line == 7] == [
        'the result depends on timing: input "before" of stage "d" samples "d" in the cycle d -> d, '
        "which has no delay"
    ]


@pytest.mark.parametrize(
    ("old", "new", "column", "said"),
    [
        ("{uses: ticks.sum,", "{uses: ticks.sum, on_error: skip,", 34, "goes on after an error"),
        ("{uses: ticks.sum,", "{uses: ticks.sum, on_error: restart,", 34, "goes on after an error"),
        ("[a, b]", "[a, {from: b, codec: jpeg}]", 59, "other pictures over Zenoh"),
    ],
)
def test_a_replay_is_not_strict_with_what_matters_everywhere(
    tmp_path: Path, old: str, new: str, column: int, said: str
) -> None:
    ((line, found, text, remedy),) = strict(tmp_path, REPLAY.replace(old, new))
    assert (line, found) == (6, column)
    assert said in text
    assert remedy in ("on_error: fail", "codec: lossless")


def test_a_stage_without_a_seed_is_found(tmp_path: Path) -> None:
    (tmp_path / "dice.py").write_text(DICE)
    text = "graph: g\nstages:\n  a: {uses: dice.roll}\n  b: {uses: sinks.csv, in: {tracks: a}}\n"
    dice = str(tmp_path / "dice.py")
    ((line, column, said, _),) = strict(tmp_path, text, dice)
    assert (line, column) == (3, 13)
    assert "random numbers without a seed" in said
    assert strict(tmp_path, text.replace("dice.roll}", "dice.roll, with: {seed: 7}}"), dice) == []


def test_mistakes_and_reasons_come_together(tmp_path: Path) -> None:
    found = strict(tmp_path, LIVE.replace("ticks.write", "ticks.rite"))
    assert [line for line, *_ in found] == [4, 5, 6, 7, 8]


def test_every_shipped_graph_with_a_room_is_strict() -> None:
    for name in ("glowballs", "person_room", "person_panorama"):
        compile_graph(ROOT / "graphs" / f"{name}.yaml", strict=True)


def test_the_command_refuses_with_places_as_text_and_as_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    graph = tmp_path / "g.yaml"
    graph.write_text(LIVE)
    words = ["check", str(graph), "--plugin", TICKS]
    assert main(words) == 0
    assert main([*words, "--json"]) == 0
    capsys.readouterr()
    assert main([*words, "--strict"]) == 2
    said = capsys.readouterr().err
    assert f"{graph}:4:13: " in said
    assert "4 mistakes, nothing was started" in said
    assert main([*words, "--strict", "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    assert [(m["line"], m["column"]) for m in found["mistakes"]] == [(4, 13), (5, 55), (6, 57), (7, 55)]

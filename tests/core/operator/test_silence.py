"""Runs in which a stage never gives anything say where they fell silent."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.commands import command

import followspot as fs
from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.operator.reporting.silence import silences as find_silences
from followspot.tracking import Blobs, Forecast, Frame, Tracks
from followspot.worker.ledger import EdgeCount

ROOT = Path(__file__).parents[3]
GRAPHS, QUIET = ROOT / "graphs", ROOT / "tests/stages/quiet.py"


def silences(folder: Path, stages: str, placement: str | None = None) -> list[str]:
    """What a run of these stages says."""
    (folder / "graph.yaml").write_text("graph: quiet\nstages:\n" + stages)
    options = {"plugin_files": [QUIET], "out": folder / "out", "placement": placement}
    with fs.run(folder / "graph.yaml", **options) as run:  # type: ignore[arg-type]
        return [f"{silence}; {silence.advice}" for silence in run.wait().silences]


SOURCE = "  a: {uses: quiet.emit}\n"
SAVED = "  save: {uses: quiet.save, in: {blobs: c}}\n"


def test_messages_that_broke_their_contract_are_not_called_empty(tmp_path: Path) -> None:
    (told,) = silences(tmp_path, SOURCE + "  c: {uses: quiet.broken, in: {blobs: a}}\n" + SAVED)
    assert "; 9 that it gave broke their contract, see the warnings; all 1 others were empty" in told


@pytest.mark.parametrize("placement", [None, "stage"])
def test_the_first_stage_that_gives_nothing_is_named_and_not_those_after_it(
    tmp_path: Path, placement: str | None
) -> None:
    stages = (
        SOURCE + "  b: {uses: quiet.drop, in: {blobs: a}}\n  c: {uses: quiet.pass, in: {blobs: b}}\n" + SAVED
    )
    assert silences(tmp_path, stages, placement) == [
        'stage "b" (quiet.drop) gave nothing at out: "a" gave it 10 messages; '
        'all 10 that it gave were empty. So "save" got nothing; look elsewhere'
    ]


def test_a_stage_that_gives_no_message_at_all_is_named(tmp_path: Path) -> None:
    stages = SOURCE + "  c: {uses: quiet.never, in: {blobs: a}}\n" + SAVED
    assert silences(tmp_path, stages) == [
        'stage "c" (quiet.never) gave nothing at out: "a" gave it 10 messages; it gave none. So "save" got '
        "nothing; `followspot echo` shows what it gets, `followspot plugins quiet.never` lists its parameters"
    ]


def test_a_run_that_fails_before_its_first_message_blames_no_source(tmp_path: Path) -> None:
    stages = f"stages:\n{SOURCE}  save: {{uses: sinks.udp_json, in: {{message: a}}, with: {{host: '::1'}}}}\n"
    (tmp_path / "graph.yaml").write_text(f"graph: quiet\n{stages}")
    done = command("run", tmp_path / "graph.yaml", "--plugin", QUIET, "--out", tmp_path / "out")
    assert "stage save failed" in done.stdout
    assert "gave nothing" not in done.stdout


def test_a_stage_to_which_no_message_came_is_not_blamed(tmp_path: Path) -> None:
    """Its worker died before it took the first one."""
    (tmp_path / "graph.yaml").write_text(
        f"graph: quiet\nstages:\n{SOURCE}  c: {{uses: quiet.pass, in: {{blobs: a}}}}\n{SAVED}"
    )
    plan = compile_graph(tmp_path / "graph.yaml", plugin_files=[QUIET])
    sent = EdgeCount(3, 0, 3, 0, 0, 0, 0, 0, 0, lost=3, filled=True)
    none = EdgeCount(0, 0, 0, 0, 0, 0, 0, 0, 0)
    counts = {"a": sent, "c": none}
    assert not find_silences(plan, [(edge, counts[edge.from_stage]) for edge in plan.edges])


def test_a_source_that_gives_nothing_is_named(tmp_path: Path) -> None:
    (line,) = silences(tmp_path, "  c: {uses: quiet.emit, with: {rows: 0}}\n" + SAVED)
    assert line.startswith(
        'stage "c" (quiet.emit) gave nothing at out. So "save" got nothing; `followspot doctor`'
    )


def test_one_message_with_rows_is_enough(tmp_path: Path) -> None:
    assert silences(tmp_path, "  c: {uses: quiet.emit, with: {first: 9}}\n" + SAVED) == []


def test_of_two_ways_to_a_sink_the_silent_one_is_named_and_the_sink_is_not(tmp_path: Path) -> None:
    stages = SOURCE + (
        "  b: {uses: quiet.drop, in: {blobs: a}}\n  c: {uses: quiet.merge, in: {blobs: [a, b]}}\n" + SAVED
    )
    (line,) = silences(tmp_path, stages)
    assert 'stage "b"' in line
    assert "got nothing" not in line


def test_a_join_is_not_blamed_for_the_silence_of_one_of_its_inputs(tmp_path: Path) -> None:
    stages = SOURCE + (
        "  b: {uses: quiet.drop, in: {blobs: a}}\n"
        "  c: {uses: quiet.both, in: {left: a, right: b, hint: a}}\n" + SAVED
    )
    (line,) = silences(tmp_path, stages)
    assert 'stage "b"' in line
    assert 'So "save" got nothing' in line


def test_messages_that_no_firing_used_are_told(tmp_path: Path) -> None:
    late = "  late: {uses: quiet.shifted}\n"
    graph = SOURCE + late + "  c: {uses: quiet.both, in: {left: a, right: late}}\n" + SAVED
    (tmp_path / "graph.yaml").write_text("graph: quiet\nstages:\n" + graph)
    with fs.run(tmp_path / "graph.yaml", plugin_files=[QUIET], out=tmp_path / "out") as run:
        (silence,) = run.wait().silences
    assert (silence.stage, silence.got, silence.unused, silence.gave) == ("c", 0, 20, 0)
    assert "20 messages, of which 20 were late or unmatched; it gave none" in str(silence)


def test_the_demo_says_where_it_fell_silent_in_text_and_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["run", str(GRAPHS / "glowballs.yaml"), "--frames", "5", "--quiet", "--out", str(tmp_path)]
    words += ["--set", "color.similarity=1.0"]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert 'gave nothing\n  stage "color" (balls.color_blobs) gave nothing at out: "camera" gave it' in text
    assert main([*words, "--json"]) == 0
    first, second = json.loads(capsys.readouterr().out)["silences"]
    assert (first["stage"], first["sinks"], second["stage"]) == ("color", ["save"], "fuse")
    assert "similarity" in first["advice"]


def test_messages_without_rows_and_numbers_are_empty() -> None:
    assert Blobs.empty().is_empty
    assert Tracks.empty().is_empty
    assert not Forecast.empty().is_empty  # its period is a number
    assert not Frame("cam0", np.zeros((1, 1, 1), np.uint8)).is_empty

"""Recorded ports by the names that the interface of a sub-graph gives them."""

from __future__ import annotations

from pathlib import Path

import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.errors import FollowspotError

PLUGIN = """
import numpy as np
from followspot import Array, Message, Source, Stage, at, column

class Beat(Message):
    loud: Array = column("N", dtype="f8", unit="1")

class Drum(Stage):
    def process(self) -> Source[Beat]:
        for bar in range(3):
            yield at(bar * 10_000_000, Beat(np.full(2, 0.5)))

class Louder(Stage):
    def process(self, beat: Beat) -> Beat:
        return Beat(2.0 * beat.loud)
"""
GRAPH = """
graph: twice
stages:
  drum: {uses: pulses.drum}
  once: {graph: louder.yaml, in: {beat: drum}}
  save: {uses: sinks.csv, in: {beat: once.beat}, with: {path: beats.csv}}
"""
LOUDER = """
graph: louder
inputs: {beat: first.beat}
outputs: {beat: second, idle: first}
stages:
  first:  {uses: pulses.louder, in: {beat: second}}
  second: {uses: pulses.louder, in: {beat: first}}
"""


@pytest.fixture(scope="module")
def show(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of the source and of the sub-graph's output; plugin and graph beside it."""
    folder = tmp_path_factory.mktemp("show")
    for name, text in (("pulses.py", PLUGIN), ("main.yaml", GRAPH), ("louder.yaml", LOUDER)):
        (folder / name).write_text(text)
    run = ["run", str(folder / "main.yaml"), "--plugin", str(folder / "pulses.py"), "--quiet"]
    recording = ["--record", str(folder / "show.mcap"), "--record-ports", "drum,once.beat"]
    assert main([*run, "--out", str(folder / "out"), *recording]) == 0
    return folder / "show.mcap"


def test_export_takes_the_name_of_an_output(show: Path, tmp_path: Path) -> None:
    assert main(["export", str(show), str(tmp_path), "--to", "csv", "--ports", "once.beat"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["once.second.out.csv"]


def test_replay_plays_the_output_in_place_of_the_stages_before_it(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replay = ["replay", str(show), "--plugin", str(show.parent / "pulses.py"), "--quiet", "--json"]
    assert main([*replay, "--ports", "once.beat", "--out", str(tmp_path)]) == 0
    assert '"once/first"' not in capsys.readouterr().out
    assert (tmp_path / "beats.csv").read_bytes() == (show.parent / "out/beats.csv").read_bytes()


def test_a_script_reads_the_output_by_its_name(show: Path) -> None:
    with fs.open_recording(show) as recording:
        assert recording["once.beat"].name == "once/second.out"
        assert len(list(recording["once.beat"])) == 3
        with pytest.raises(FollowspotError, match=r'no port "once.beta"; did you mean "once.beat"'):
            _ = recording["once.beta"]


def test_an_output_that_was_not_recorded_is_no_port(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(show), str(tmp_path), "--to", "csv", "--ports", "once.idle"]) == 2
    assert 'there is no port "once.idle"' in capsys.readouterr().err

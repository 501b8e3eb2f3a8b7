"""`followspot graph --flat` and `--origin`: the composed graph as one file, and where its parts come from."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from tests.core.graph.composed import write
from tests.core.graph.files import TOY
from tests.core.graph.subgraph_files import MIDDLE, NESTED, SHARED, TWO

from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.yaml.node import dump, plain
from followspot.yaml.reader import parse


def printed(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert main(["graph", *map(str, words), "--plugin", TOY]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("text", [TWO, SHARED, NESTED], ids=["two", "shared", "nested"])
def test_the_flat_file_gives_the_same_plan(
    tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, main=text, middle=MIDDLE)
    flat = tmp_path / "elsewhere" / "flat.yaml"
    flat.parent.mkdir()
    flat.write_text(printed(capsys, tmp_path / "main.yaml", "--flat", "--set", "save.path=x.csv"))
    assert all("graph" not in entry for entry in yaml.safe_load(flat.read_text())["stages"].values())
    nested = compile_graph(tmp_path / "main.yaml", overrides=["save.path=x.csv"], plugin_files=[TOY])
    found, wanted = plan_to_data(compile_graph(flat, plugin_files=[TOY])), plan_to_data(nested)
    for names in ("offered", "subgraphs"):
        assert wanted.pop(names), "of the interfaces, which the flat file has not"
    for one in (*found["stages"], *wanted["stages"]):
        one["kept"] = []  # what --set gives the nested graph, the flat file says
    assert found == wanted


def test_input_paths_of_a_flat_file_are_absolute(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, over="extends: graph.yaml\nstages: {pair: {uses: toy.masked, with: {mask: room.yaml}}}\n")
    found = yaml.safe_load(printed(capsys, tmp_path / "over.yaml", "--flat"))
    assert found["stages"]["pair"]["with"] == {"mask": str(tmp_path / "room.yaml")}
    assert found["room"] == str(tmp_path / "room.yaml")
    assert found["stages"]["save"]["with"] == {"path": "tracks.csv"}


def test_the_origin_of_every_stage_and_value_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write(
        tmp_path, main=NESTED, middle=MIDDLE, over="extends: main.yaml\nstages: {save: {with: {path: y.csv}}}"
    )
    monkeypatch.chdir(tmp_path)
    lines = printed(capsys, "over.yaml", "--origin", "--set", "hall.level=0.125").splitlines()
    rows = {tuple(line.split(maxsplit=1)) if line[0] != " " else line.strip() for line in lines}
    assert ("hall/inner/track", "tracker.yaml:12 < middle.yaml:6 < main.yaml:5 < over.yaml:1") in rows
    assert any(row[:5] == "with." and "y.csv" in row and row.endswith("over.yaml:2") for row in rows)
    assert any("with.level: 0.125" in row and row.endswith("--set:1") for row in rows)
    assert any("in.tracks: hall/inner/track.tracks" in row and row.endswith("main.yaml:6") for row in rows)


@pytest.mark.parametrize(
    "text", ["1e5", "0o17", "012", "0x1F", "yes", "null", "~", "1_000", "1:30", "", "a: b"]
)
def test_text_that_looks_like_something_else_stays_text(text: str) -> None:
    assert plain(parse(dump({"a": [text], text or "b": 1.5e-7}), "x")) == {"a": [text], text or "b": 1.5e-7}


def test_cameras_that_a_flat_file_cannot_choose_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    graph = str(Path(__file__).parents[3] / "graphs/glowballs.yaml")
    assert main(["graph", graph, "--flat", "--cameras", "cam0,cam1"]) == 0
    assert "note: a graph file chooses no cameras: run it with --cameras cam0,cam1" in capsys.readouterr().err

"""The graphs that are installed with followspot: listed, copied, and run as the demo from any folder."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from tests.packages import build
from tests.plugins.persons.pose_net.tiny_models import lit, movenet_row
from tests.tools.page.bundled import bundle

from followspot.cli.main import main
from followspot_graphs.shipped import graphs_folder, shipped_graphs

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_every_graph_is_listed_with_what_it_is_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["graphs"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == sorted(
        path.stem for path in (ROOT / "graphs").glob("*.yaml")
    )
    assert all(line.endswith((".", ". Needs --room.")) for line in lines), "a sentence each"
    assert main(["graphs", "--json"]) == 0
    told = {graph["name"]: graph for graph in json.loads(capsys.readouterr().out)["graphs"]}
    assert told["covered"]["room"] == "simulated", "that of the graph it extends"
    assert told["people"]["room"] is None


@pytest.mark.parametrize("name", [graph.name for graph in shipped_graphs() if graph.room])
def test_a_copied_graph_has_all_that_it_needs(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["graphs", name]) == 0
    assert f"graphs/{name}.yaml" in capsys.readouterr().out.splitlines()
    if "model.onnx" in (tmp_path / f"graphs/{name}.yaml").read_text():
        pytest.importorskip("onnxruntime")
        rows = np.stack([movenet_row(0.0)] * 6)
        (tmp_path / "graphs/model.onnx").write_bytes(lit(rows))  # in place of the user's
    assert main(["check", f"graphs/{name}.yaml"]) == 0


def test_what_was_changed_is_never_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["graphs", "glowballs", "--to", "mine"]) == 0
    mine = tmp_path / "mine" / "glowballs.yaml"
    mine.write_text(mine.read_text() + "# mine\n")
    capsys.readouterr()
    assert main(["graphs", "show", "--to", "mine"]) == 2
    assert "mine/glowballs.yaml exists and says something else" in capsys.readouterr().err
    assert not (tmp_path / "mine" / "show.yaml").exists(), "nothing was copied"
    assert mine.read_text().endswith("# mine\n")
    assert main(["graphs", "glowbals"]) == 2
    assert 'did you mean "glowballs"?' in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("a file")
    assert main(["graphs", "glowballs", "--to", "taken"]) == 2
    assert "taken cannot be written" in capsys.readouterr().err


def test_the_demo_runs_in_any_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--frames", "2", "--quiet", "--set", "save.path=mine.csv", "--out", "out"]) == 0
    assert (tmp_path / "out" / "mine.csv").read_text().count("\n") > 1
    assert "outputs: out" in capsys.readouterr().out


@pytest.mark.thorough
def test_a_wheel_has_the_graphs(tmp_path: Path) -> None:
    bundle()
    with zipfile.ZipFile(build("wheel", ROOT, tmp_path / "wheel")) as wheel:
        found = {name for name in wheel.namelist() if name.startswith("followspot_graphs/shipped/")}
        for name in found:
            shipped = graphs_folder() / name.removeprefix("followspot_graphs/shipped/")
            assert wheel.read(name) == shipped.read_bytes()
    assert {
        f"followspot_graphs/shipped/{path.relative_to(graphs_folder())}"
        for path in graphs_folder().rglob("*.yaml")
    } <= found

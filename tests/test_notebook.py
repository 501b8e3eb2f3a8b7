"""The cells of docs/notebook.md run, one after the other, as in a notebook."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CELL = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_the_notebook_runs_from_its_first_cell_to_its_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("mcap")
    shutil.copytree(ROOT / "graphs", tmp_path / "graphs")
    (tmp_path / "runs" / "notebook").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    cells = CELL.findall((ROOT / "docs" / "notebook.md").read_text())
    assert len(cells) >= 6
    module = type(sys)("notebook")
    monkeypatch.setitem(sys.modules, "notebook", module)
    for number, cell in enumerate(cells):
        exec(compile(cell, f"cell {number}", "exec"), module.__dict__)


def test_the_run_that_the_readme_shows_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(ROOT / "graphs", tmp_path / "graphs")
    room = tmp_path / "graphs" / "rooms" / "simulated.yaml"
    room.write_text(room.read_text().replace("frames: 1200", "frames: 120"))
    monkeypatch.chdir(tmp_path)
    cells = [cell for cell in CELL.findall((ROOT / "README.md").read_text()) if "fs.run(" in cell]
    assert len(cells) == 1
    exec(compile(cells[0], "README", "exec"), {})
    assert "accuracy against ground truth" in capsys.readouterr().out

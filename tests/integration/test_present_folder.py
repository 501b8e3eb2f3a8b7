"""A run in a folder with Python files of others: they take the place of no module of the program."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

GRAPH = Path(__file__).parents[2] / "graphs/glowballs.yaml"


@pytest.mark.parametrize("placement", [(), ("--placement", "camera", "--keep", "5s")], ids=["one", "workers"])
def test_files_of_the_present_folder_are_not_imported(tmp_path: Path, placement: tuple[str, ...]) -> None:
    for name in ("random", "numpy", "queue", "followspot_balls"):
        (tmp_path / f"{name}.py").write_text('raise SystemExit("an experiment")\n')
    command = [Path(sys.executable).with_name("followspot"), "run", GRAPH, "--frames", "3", "--out", "out"]
    done = subprocess.run([*command, *placement, "-q"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out/tracks.csv").stat().st_size > 100

"""Without the package filterpy its stage is not installed, and every command says how to install it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
GRAPH = str(ROOT / "graphs" / "glowballs.yaml")
REMEDY = "pip install 'followspot[filterpy]'"


def told(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A command where the package is missing."""
    missing = "raise ModuleNotFoundError(\"No module named 'filterpy'\", name='filterpy')"
    (folder / "filterpy.py").write_text(missing)
    main = "import sys; from followspot.cli.main import main; sys.exit(main())"
    command = [sys.executable, "-c", main, *words]
    there = {**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "400"}
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=there)


def line(text: str, part: str) -> str:
    return next(line for line in text.splitlines() if part in line)


@pytest.mark.parametrize(("command", "code"), [("plugins", 0), ("doctor", None)])
def test_lists_say_that_it_is_not_installed_and_do_not_call_it_broken(
    tmp_path: Path, command: str, code: int | None
) -> None:
    done = told(tmp_path, command)
    assert code is None or done.returncode == code, done.stderr
    found = line(done.stdout, "filters.kalman_filterpy")
    assert "not installed" in found
    assert REMEDY in found
    assert "broken" not in found
    assert "problem" not in found


def test_a_graph_that_uses_it_is_refused_with_the_remedy(tmp_path: Path) -> None:
    done = told(tmp_path, "check", GRAPH, "--set", "track.uses=filters.kalman_filterpy")
    assert done.returncode == 2, done.stdout
    assert "filters.kalman_filterpy: not installed" in done.stderr
    assert REMEDY in done.stderr
    assert "Traceback" not in done.stderr

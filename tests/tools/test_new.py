"""A new plugin is a package that works before a line of it is written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from followspot.errors import InputError
from followspot_new.package import new_plugin, new_stage


def run(folder: Path, *words: str, path: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(path)}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The folder of a new plugin with a second stage, and where it was installed."""
    folder = new_plugin("studio", tmp_path_factory.mktemp("work"))
    new_stage("shout_loud", folder)
    site = tmp_path_factory.mktemp("site")
    done = run(
        folder,
        *("-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--target", str(site), "."),
        path=site,
    )
    if "Cannot import 'hatchling" in done.stderr or "No module named 'hatchling'" in done.stderr:
        pytest.fail("hatchling is missing: pip install -e '.[dev]'")
    assert done.returncode == 0, done.stderr
    return folder, site


def test_its_first_test_run_is_green(made: tuple[Path, Path]) -> None:
    folder, site = made
    done = run(folder, "-m", "pytest", "-q", path=site)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "4 passed" in done.stdout


def test_its_stage_is_installed_and_its_graph_is_sound(made: tuple[Path, Path]) -> None:
    folder, site = made
    told = run(folder, "-m", "followspot.cli.main", "plugins", "studio.shout_loud", path=site)
    assert "Keep the tracks below a height" in told.stdout
    checked = run(folder, "-m", "followspot.cli.main", "check", "graph.yaml", path=site)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_its_graph_runs(made: tuple[Path, Path]) -> None:
    folder, site = made
    words = ("-m", "followspot.cli.main", "run", "graph.yaml", "--frames", "60", "--out", "out")
    done = run(folder, *words, path=site)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = (folder / "out" / "low.csv").read_text().splitlines()
    assert len(rows) > 60
    assert all(float(row.split(",")[6]) < 1.2 for row in rows[1:])


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    folder = new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="exists already"):
        new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="exists already"):
        new_stage("low", folder)


@pytest.mark.parametrize("name", ["Studio", "../escape", "my-plugin", "", "a b", "1st"])
def test_a_name_that_is_no_module_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="cannot be the name"):
        new_plugin(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_taken_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="comes with followspot"):
        new_plugin("balls", tmp_path)


def test_a_stage_outside_of_a_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no"):
        new_stage("shout", tmp_path)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "other"\n')
    with pytest.raises(InputError, match="is not one that"):
        new_stage("shout", tmp_path)

"""What the system does not give to a run is told, by a remedy and without a traceback."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tests.commands import COMMAND

GRAPH = Path(__file__).parents[3] / "graphs/glowballs.yaml"


@pytest.mark.parametrize("files", [pytest.param(25, marks=pytest.mark.thorough), 40, 64])
def test_too_few_open_files_for_the_workers_are_told(tmp_path: Path, files: int) -> None:
    words = [*COMMAND, "run", str(GRAPH), "--placement", "stage", "--frames", "2", "--out", "out", "-q"]
    limited = ["prlimit", f"--nofile={files}", *words]
    done = subprocess.run(limited, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr == (
        "followspot: the workers cannot be started: Too many open files\n    raise the limit of open files, "
        "for example ulimit -n 4096, or take fewer workers: --placement\n"
    )


@pytest.mark.parametrize("placement", [(), ("--placement", "stage")])
def test_a_limit_of_the_size_of_files_is_told_with_its_own_remedy(
    tmp_path: Path, placement: tuple[str, ...]
) -> None:
    words = [*COMMAND, "run", str(GRAPH), *placement, "--frames", "2", "--out", "out", "-q"]
    limited = ["prlimit", "--fsize=1000", "env", "PYTHONDONTWRITEBYTECODE=1", *words]
    done = subprocess.run(limited, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr == (
        "followspot: the workers cannot be started: File too large\n"
        "    raise the limit of the size of a file: ulimit -f unlimited\n"
    )

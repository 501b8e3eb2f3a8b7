"""The tutorial works when it is followed literally: each of its blocks, in order."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
STEP = re.compile(r"(?P<before>[^\n]*)\n\n```(?P<language>\w+)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)
SET_UP = ("make demo", ". .venv/bin/activate")
"""What a checkout has done before its tests run."""


class Reader:
    """Someone in a terminal, who does what stands there."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.site = folder, folder / "site"
        self.said: dict[str, str] = {}

    def does(self, language: str, text: str, before: str) -> None:
        if language == "sh":
            for line in text.splitlines():
                self._types(line)
        elif language == "python":
            (self.folder / re.findall(r"`([\w/]+\.py)`", before)[-1]).write_text(text)
        else:
            with (self.folder / "graph.yaml").open("a") as graph:
                graph.write(text)

    def _types(self, line: str) -> None:
        if line in SET_UP:
            return
        if line.startswith("cd "):
            self.folder /= line.removeprefix("cd ")
            return
        if line.startswith("pip install"):  # beside the environment of these tests, not into it
            line = f"pip install --quiet --no-deps --no-build-isolation --upgrade --target {self.site} ."
        words = {
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "PYTHONPATH": f"{self.folder}:{self.site}",
        }
        folder = ROOT if "graphs/" in line else self.folder
        out = f" --out {self.folder / 'demo'}" if line.startswith("followspot run graphs/") else ""
        done = subprocess.run(
            line + out, shell=True, cwd=folder, env=os.environ | words, capture_output=True, text=True
        )
        assert done.returncode == 0, line + "\n" + done.stdout + done.stderr
        self.said[line] = done.stdout
        if line.startswith("followspot run graph.yaml"):
            rows = (self.folder / "out" / "fast.csv").read_bytes()
            assert self.said.setdefault("fast.csv", rows.hex()) == rows.hex(), "placement changed the result"


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Reader:
    """One who has followed the whole tutorial."""
    reader = Reader(tmp_path_factory.mktemp("work"))
    for step in STEP.finditer((ROOT / "docs/tutorial.md").read_text()):
        reader.does(step["language"], step["text"], step["before"])
    return reader


def test_the_first_test_run_of_the_new_package_is_green(reader: Reader) -> None:
    assert re.search(r"= \d+ passed in ", reader.said["pytest"]), reader.said["pytest"]


def test_the_new_stage_ran_in_the_graph(reader: Reader) -> None:
    rows = (reader.folder / "out" / "fast.csv").read_text().splitlines()
    every = (reader.folder / "out" / "low.csv").read_text().splitlines()
    speeds = [sum(float(v) ** 2 for v in row.split(",")[7:10]) ** 0.5 for row in rows[1:]]
    assert len(rows) > 20
    assert min(speeds) >= 0.5 - 1e-6
    assert len(every) > len(rows)


def test_a_broken_graph_is_told_with_its_place_and_a_remedy(reader: Reader) -> None:
    graph = reader.folder / "broken.yaml"
    graph.write_text((reader.folder / "graph.yaml").read_text().replace("studio.fast", "studio.fats"))
    path = {"PYTHONPATH": f"{reader.folder}:{reader.site}"}
    words = [sys.executable, "-m", "followspot.cli.main", "check", graph]
    done = subprocess.run(words, env=os.environ | path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert re.search(r"broken\.yaml:\d+:\d+.*studio\.fats", done.stderr)
    assert "studio.fast" in done.stderr

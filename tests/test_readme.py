"""The README is true: its graph is the demo's, its stage runs, its table is whole, its pictures are there."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from followspot.plugins.registry import load_stage, use_plugin_files
from followspot.tracking import Tracks

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_graph_shown_is_the_demo_graph() -> None:
    assert blocks("yaml")[0] == (ROOT / "graphs/glowballs.yaml").read_text()


def test_the_stage_shown_is_short_and_runs_as_a_one_file_plugin(tmp_path: Path) -> None:
    text = blocks("python")[0]
    assert len(text.strip().splitlines()) < 15
    file = tmp_path / "low.py"
    file.write_text(text)
    use_plugin_files([str(file)])
    xyz = np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.7]])
    zeros = np.zeros((2, 3))
    tracks = Tracks(np.array([0, 1], "i4"), np.ones(2, "u1"), xyz, zeros, zeros)
    assert load_stage("low.low")(height=0.5).process(tracks).target.tolist() == [0]


def test_the_table_lists_every_command() -> None:
    rows = [line for line in README.splitlines() if line.startswith("| `followspot ")]
    shown = {name for row in rows for name in re.findall(r"`followspot ([a-z]+)", row.split("|")[1])}
    out = subprocess.run(
        [sys.executable, "-m", "followspot.cli.main", "--help"], capture_output=True, text=True, check=True
    )
    listed = set(re.findall(r"^    ([a-z]+) ", out.stdout, re.MULTILINE)) | set(
        re.findall(r"^    ([a-z]+)$", out.stdout, re.MULTILINE)
    )
    assert shown == listed


def test_every_picture_is_there() -> None:
    for path in re.findall(r"!\[.*?\]\((.*?)\)", README):
        assert (ROOT / path).stat().st_size > 10_000


def test_help_answers_without_heavy_imports() -> None:
    probe = (
        "import sys; from followspot.cli.parser import build_parser; build_parser().format_help();"
        "print([m for m in ('cv2', 'scipy', 'zenoh', 'numpy', 'pydantic') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"

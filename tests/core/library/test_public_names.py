"""What `import followspot` offers shows itself: to editors, type checkers and notebooks."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import followspot as fs
from followspot.tracking import Blobs

TYPED = """
from typing import Any, assert_type

import followspot as fs
from followspot.tracking import Tracks

with fs.run("graph.yaml") as run:
    assert_type(run.subscribe("track.tracks", Tracks), fs.Subscription[Tracks])
    for tracks in run.subscribe("track.tracks", Tracks):
        assert_type(tracks, Tracks)
        print(tracks.xyz)
    for message in run["track.tracks"]:
        print(message.xyz)
    assert_type(next(fs.connect().subscribe("fuse", Tracks)), Tracks)
"""


@pytest.mark.thorough
def test_type_checkers_know_the_messages_of_a_subscription(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(TYPED)
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", "script.py"]
    checked = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


def test_editors_see_everything() -> None:
    assert {"run", "connect", "check", "Graph", "open_recording", "Stage", "at"} <= set(dir(fs))
    for name in dir(fs):
        assert name == "Source" or getattr(fs, name).__doc__, name


def test_a_script_knows_the_type_of_everything_but_tables_of_pandas() -> None:
    held = (fs.OwnRun, fs.ConnectedRun, fs.Subscription, fs.Report, fs.Table, fs.Recording, fs.Graph)
    methods = {f"{kind.__name__}.{name}": method for kind in held for name, method in vars(kind).items()}
    functions = {"run": fs.run, "connect": fs.connect, "check": fs.check, "open_recording": fs.open_recording}
    returned = {
        name: str(inspect.signature(function).return_annotation)
        for name, function in (methods | functions).items()
        if inspect.isfunction(function) and "._" not in name
    }
    assert {name for name, kind in returned.items() if kind == "Any"} == {"Table.to_pandas"}


def test_a_message_shows_itself() -> None:
    shown = fs.at(7, Blobs.empty())._repr_html_()
    assert "<caption>Blobs -1 of no source at 7 ns</caption>" in shown
    assert "<td>xy</td><td>0 x 2</td><td>px</td>" in shown

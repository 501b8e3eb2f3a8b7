"""Files in folders whose names are no UTF-8, as of other systems: no library may crash on them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from tests.commands import command
from tests.plugins.cameras.recordings import context, record

from followspot import Room, room_file

GRAPH = """\
graph: g
room: room.yaml
stages:
  camera: {{uses: {uses}, each: cameras, with: {{path: {path}}}}}
  draw: {{uses: sinks.draw, in: {{frames: camera}}, with: {{format: {form}}}}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of such a name with a room and a video."""
    folder = tmp_path / os.fsdecode("Aufnahme für mich".encode("latin-1"))
    folder.mkdir()
    (camera,) = context().room.cameras.values()
    room_file.save(Room("r", {camera.name: camera}), folder / "room.yaml")
    record(tmp_path / "a.mkv", frames=3).rename(folder / "a.mkv")
    return folder


def drawn(folder: Path, uses: str, path: str, form: str) -> None:
    """Run a graph that copies the pictures of a camera."""
    (folder / f"{form}.yaml").write_text(GRAPH.format(uses=uses, path=path, form=form))
    done = command("run", f"{form}.yaml", "--out", form, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "3 frames" in done.stdout


def test_videos_and_pictures_are_read_and_written_there(folder: Path) -> None:
    drawn(folder, "cameras.video", "a.mkv", "png")
    drawn(folder, "cameras.images", "png/drawn/cam3", "mkv")
    drawn(folder, "cameras.video", "mkv/drawn/cam3.mkv", "jpg")
    assert len(list((folder / "jpg/drawn/cam3").iterdir())) == 3
    done = command("room", "new", "--video", "a.mkv", "-o", "new.yaml", cwd=folder)
    assert done.returncode == 0, done.stderr

"""`sync` in a room file: how its cameras are triggered together."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from followspot import InputError, Room
from followspot.room import Sync
from followspot.room_file import load, save
from followspot.testing.tiny_room import tiny_room


def written(folder: Path, text: str) -> Path:
    save(tiny_room(), folder / "room.yaml")
    with (folder / "room.yaml").open("a") as file:
        file.write(f"sync: {text}\n")
    return folder / "room.yaml"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{trigger: software, rate: 29.97}", Sync("software", rate=29.97)),
        ("{trigger: line, camera: cam0}", Sync("line", "cam0")),
        ("{trigger: line, camera: cam0, rate: 60, match: time}", Sync("line", "cam0", 60.0, match="time")),
        (
            "{trigger: action, camera: cam0, rate: 60, device_key: 66, group_key: 2, group_mask: 0}",
            Sync("action", "cam0", 60.0, 66, 2, 0),
        ),
    ],
)
def test_sync_is_read_and_written(tmp_path: Path, text: str, expected: Sync) -> None:
    room = load(written(tmp_path, text))
    assert room.sync == expected
    save(room, tmp_path / "again.yaml")
    assert load(tmp_path / "again.yaml").sync == expected
    assert load(written(tmp_path, "").with_name("room.yaml")).sync is None


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("{rate: 30}", 'sync lacks "trigger"'),
        ("{trigger: softwar, rate: 30}", 'did you mean "software"'),
        ("{trigger: software}", 'sync lacks "rate"'),
        ("{trigger: software, rate: 0}", "rate"),
        ("{trigger: line}", 'sync lacks "camera"'),
        ("{trigger: line, camera: cam9}", r'there is no camera "cam9"(.|\n)*cam0'),
        ("{trigger: action, camera: cam0, rate: 5, group_key: 1.5}", "group_key is no whole number"),
        ("{trigger: action, camera: cam0, rate: 5, device_key: 4294967296}", "device_key"),
        ("{trigger: line, camera: cam0, match: tim}", 'did you mean "time"'),
        ("{trigger: line, camera: cam0, fps: 3}", 'sync has no key "fps"'),
    ],
)
def test_mistake_in_sync_is_told_at_its_line(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(InputError, match=complaint) as caught:
        load(written(tmp_path, text))
    assert all(mistake.place is not None for mistake in caught.value.mistakes)


def test_a_room_that_is_written_without_sync_says_nothing_of_it(tmp_path: Path) -> None:
    save(replace(Room(), name="r"), tmp_path / "room.yaml")
    assert "sync" not in (tmp_path / "room.yaml").read_text()

"""`followspot cameras`: what is in sight, and entries of a room file for what the room lacks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.plugins.cameras.genicam_port import own_port

from followspot import room_file
from followspot.cli.main import main
from followspot.room import Camera
from followspot_cameras.genicam.camera import CameraInfo
from followspot_cameras.genicam.facts import Facts
from followspot_cameras.genicam.room_entries import entries


def info(serial: str, name: str = "") -> CameraInfo:
    return CameraInfo("viva-genicam", "aa", "GigE Vision", "10.0.0.7", "Acme", "A1", serial, name)


def test_cameras_that_a_room_lacks_are_added_with_their_serial_numbers() -> None:
    first = entries([(info("7", "left side"), Facts((640, 480), "BayerRG8"))], {})
    assert list(first) == ["left_side"]
    camera = first["left_side"]
    assert camera.source is not None
    assert (camera.kind, camera.size, dict(camera.source.params)) == ("color", (640, 480), {"camera": "7"})
    found = [
        (info("7", "left side"), Facts((640, 480), "BayerRG8")),
        (info("8", "left side"), Facts((64, 48), "Mono8")),
        (info("9"), Facts(problem="in use")),
    ]
    second = entries(found, first)
    assert list(second) == ["left_side", "left_side_2"]
    assert second["left_side"] is camera
    assert second["left_side_2"].kind == "infrared"


@pytest.mark.parametrize("seconds", ["nan", "inf", "-1", "0", "1e300", "soon"])
def test_a_time_for_answers_that_is_none_is_refused(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["cameras", "--timeout", seconds])
    assert "argument --timeout: " in capsys.readouterr().err


def test_a_camera_that_the_room_names_by_its_address_is_known() -> None:
    named = entries([(info(""), Facts((64, 48), "Mono8"))], {})
    assert list(named) == ["cam10_0_0_7"]
    assert list(entries([(info("7"), Facts((64, 48), "Mono8"))], named)) == ["cam10_0_0_7"]


def listed(room: Path, capsys: pytest.CaptureFixture[str], *, as_json: bool) -> str:
    """What the command prints; on a busy machine the answer of a camera may come too late for one search."""
    from followspot_cameras.genicam.listing import cameras

    for _ in range(20):
        capsys.readouterr()
        if cameras("any", "127.0.0.1", 0.3, room, as_json=as_json) == 0:
            break
    return capsys.readouterr().out


def test_the_list_says_what_the_camera_says_and_the_room_file_is_read_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    testing = pytest.importorskip("viva_genicam.testing", reason="viva-genicam is not installed")
    from followspot_cameras.genicam.listing import cameras

    room = tmp_path / "studio.yaml"
    with own_port():
        with testing.FakeGigeCamera(320, 240, pixel_format="Mono8"):
            text = listed(room, capsys, as_json=False)
            told = json.loads(listed(room, capsys, as_json=True))
        assert cameras("any", "127.0.0.1", 0.1, None, as_json=False) == 1
    assert "no camera is in sight" in capsys.readouterr().out
    assert "added camVIVA-FAKE-001" in text
    (camera,) = told["cameras"]
    assert (camera["serial"], camera["size"], camera["format"], camera["rate"], camera["clock"]) == (
        "VIVA-FAKE-001", [320, 240], "Mono8", 30.0, "readable",
    )  # fmt: skip
    assert told["added"] == []
    found: Camera = room_file.load(room).cameras["camVIVA-FAKE-001"]
    assert found.size == (320, 240)
    assert found.source is not None
    assert found.source.uses == "cameras.genicam"

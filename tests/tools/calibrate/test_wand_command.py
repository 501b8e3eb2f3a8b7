"""`followspot calibrate wand`: arguments, frames of reference, the room file it writes."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, made_room

from followspot import Room
from followspot.cli.main import main
from followspot.geometry import project
from followspot.room import StageUse
from followspot.room_file import load, save


@pytest.fixture(scope="module")
def made() -> MadeRoom:
    return made_room(4, 150, noise=0.2)


@pytest.fixture
def points(made, tmp_path):
    seen = made.sightings
    lines = [
        f"{frame},{name},{u!r},{v!r}"
        for frame, views in zip(seen.frame.tolist(), seen.pixel.tolist(), strict=True)
        for name, (u, v) in zip(seen.cameras, views, strict=True)
        if np.isfinite(u)
    ]
    path = tmp_path / "points.csv"
    path.write_text("frame,camera,u,v\n" + "\n".join(lines))
    return path


@pytest.fixture
def room(made, tmp_path):
    """A room file whose cameras have been turned since; their centres are still right."""
    stale = {c.name: replace(c, rotation=np.eye(3), translation=-c.center) for c in made.cameras}
    save(Room("studio", stale, {"floor": np.array([0.0, 0.0, 1.0, 0.0])}), tmp_path / "room.yaml")
    path = tmp_path / "room.yaml"
    path.write_text("# the truss was rebuilt in May\n" + path.read_text())
    return path


def test_the_room_file_gets_the_poses_and_keeps_the_rest(made, points, room, capsys):
    assert main(["calibrate", "wand", "--points", str(points), "--room", str(room)]) == 0
    text = room.read_text()
    assert text.startswith("# the truss was rebuilt in May")
    assert "floor" in text
    for name, camera in load(room).cameras.items():
        true = made.cameras[int(name[3:])]
        assert camera.rotation == pytest.approx(true.rotation, abs=0.003)
        assert camera.center == pytest.approx(true.center, abs=0.005)
        assert camera.matrix.tolist() == true.matrix.tolist()
    told = capsys.readouterr()
    assert "known centers met within" in told.out
    assert "points that pairs share" in told.out
    assert told.err == ""


def test_a_new_room_comes_from_points_alone(points, tmp_path, capsys):
    new = tmp_path / "new.yaml"
    arguments = ["calibrate", "wand", "--points", str(points), "--size", "640x480", "-o", str(new), "--json"]
    assert main(arguments) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert found["metric"] is False
    assert found["intrinsics"] == "free"
    assert found["median_px"] < 0.3
    assert [pair["shared"] >= 30 for pair in found["pairs"]] == [True] * 6
    assert "warning: the scale is unknown" in told.err
    centers = [camera.center for camera in load(new).cameras.values()]
    assert np.mean(centers, axis=0) == pytest.approx(np.zeros(3), abs=1e-9)


def test_cameras_found_from_nothing_keep_what_the_room_says_of_them(made, points, tmp_path):
    cameras = {c.name: replace(c, host="left", clock_offset=0.004) for c in made.cameras}
    cameras["cam1"] = replace(cameras["cam1"], kind="infrared")
    save(Room("studio", cameras), tmp_path / "room.yaml")
    arguments = ["--points", str(points), "--room", str(tmp_path / "room.yaml"), "--intrinsics", "free"]
    assert main(["calibrate", "wand", *arguments]) == 0
    found = load(tmp_path / "room.yaml").cameras
    assert [camera.kind for camera in found.values()] == ["color", "infrared", "color", "color"]
    assert {(camera.host, camera.clock_offset) for camera in found.values()} == {("left", 0.004)}
    assert found["cam0"].matrix.tolist() != made.cameras[0].matrix.tolist()


def test_a_marker_gives_the_frame(made, points, room, tmp_path, capsys):
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 1]], float)
    lines = ["x,y,z,camera,u,v"]
    for number, camera in enumerate(made.cameras):
        for (x, y, z), (u, v) in zip(places.tolist(), project(camera, places).tolist(), strict=True):
            lines.append(f"{x},{y},{z},{number},{u!r},{v!r}")
    marker = tmp_path / "marker.csv"
    marker.write_text("\n".join(lines))
    arguments = ["calibrate", "wand", "--points", str(points), "--room", str(room), "--marker", str(marker)]
    assert main([*arguments, "-o", str(tmp_path / "other.yaml")]) == 0
    for name, camera in load(tmp_path / "other.yaml").cameras.items():
        assert camera.center == pytest.approx(made.cameras[int(name[3:])].center, abs=0.01)
    assert "its planes are not: calibrate planes again" in capsys.readouterr().err


def test_a_camera_that_was_moved_is_named_and_does_not_bend_the_room(made, points, tmp_path, capsys):
    lines = ["camera,x,y,z", *(centre(camera, 0.4 * (camera.name == "cam2")) for camera in made.cameras)]
    centers = tmp_path / "centers.csv"
    centers.write_text("\n".join(lines))
    save(Room("studio", {c.name: c for c in made.cameras}), tmp_path / "room.yaml")
    arguments = ["--points", str(points), "--room", str(tmp_path / "room.yaml"), "--centers", str(centers)]
    assert main(["calibrate", "wand", *arguments]) == 0
    assert "cam2 is 399 mm from its known centre" in capsys.readouterr().err
    for name, camera in load(tmp_path / "room.yaml").cameras.items():
        assert camera.center == pytest.approx(made.cameras[int(name[3:])].center, abs=0.01)


def test_sources_are_still_found_from_another_folder(made, points, tmp_path):
    source = StageUse("cameras.video", {"path": "clips/cam0.mkv"}, str(tmp_path))
    cameras = {c.name: c for c in made.cameras} | {"cam0": replace(made.cameras[0], source=source)}
    save(Room("studio", cameras), tmp_path / "room.yaml")
    (tmp_path / "rooms").mkdir()
    output = tmp_path / "rooms/new.yaml"
    arguments = ["--points", str(points), "--room", str(tmp_path / "room.yaml"), "-o", str(output)]
    assert main(["calibrate", "wand", *arguments]) == 0
    assert load(output).cameras["cam0"].source.params["path"] == "../clips/cam0.mkv"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "there is no room file to write"),
        (["-o", "r.yaml", "--intrinsics", "known"], "give --room ROOM"),
        (["-o", "r.yaml", "--align", "marker"], "give --marker CSV"),
        (["-o", "r.yaml", "--length", "-1"], "is not positive"),
        (["-o", "r.yaml", "--size", "large"], "as 640x480"),
        (["-o", "r.yaml", "--size", "0x10"], "no size of a picture"),
        (["-o", "r.yaml"], "give --size"),
        (["-o", "r.yaml", "--size", "640x480", "--align", "centers"], "three are needed"),
    ],
)
def test_arguments_that_do_not_go_together_are_told(points, arguments, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", "wand", "--points", str(points), *arguments]) == 2 or "three" in told
    assert told in capsys.readouterr().err
    assert not (tmp_path / "r.yaml").exists()


def test_help_has_an_example(capsys):
    with pytest.raises(SystemExit):
        main(["calibrate", "wand", "--help"])
    assert "followspot calibrate wand --points wand.csv --room room.yaml" in capsys.readouterr().out


def centre(camera, off: float) -> str:
    x, y, z = camera.center.tolist()
    return f"{camera.name},{x + off!r},{y!r},{z!r}"

"""Upright cameras in place of tilted ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot import Camera, Context, Room, Target, room_file
from followspot.cli.main import main
from followspot.geometry import project
from followspot.room import StageUse
from followspot_cameras.video.rectified import RectifiedVideo, rectification
from followspot_room.rectifying import rectified

SIZE = (320, 240)
PLACE = np.array([0.4, -0.3, 1.8])


def tilted(roll: float = 0.3, pitch: float = 0.25, model: str = "pinhole") -> Camera:
    """Looks along x, down by `pitch`, and is turned about its axis by `roll`, rad."""
    c, s = np.cos(pitch), np.sin(pitch)
    upright = np.array([[0.0, -1.0, 0.0], [-s, 0.0, -c], [c, 0.0, -s]])
    turn = np.array([[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1.0]])
    rotation = turn @ upright
    lens = np.array([-0.05, 0.01, 0.0, 0.0] if model == "fisheye" else [-0.2, 0.05, 0.001, -0.001, 0.0])
    return Camera(
        name="cam",
        kind="color",
        size=SIZE,
        matrix=np.array([[250.0, 0, 163.0], [0, 252.0, 118.0], [0, 0, 1]]),
        distortion=lens,
        rotation=rotation,
        translation=-rotation @ PLACE,
        model=model,  # type: ignore[arg-type]
        source=StageUse("cameras.video", {"path": "cam.avi"}, "."),
    )


@pytest.mark.parametrize("model", ["pinhole", "fisheye"])
@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_a_point_is_shown_where_the_upright_camera_says(model: str, scale: float) -> None:
    taken = tilted(model=model)
    upright = rectified(taken, scale)
    assert np.allclose(upright.center, taken.center)
    for point in ([4.0, 0.0, 1.0], [3.0, 0.8, 1.4], [5.0, -1.0, 0.3]):
        u, v = project(taken, np.array([point]))[0]
        y, x = np.mgrid[: SIZE[1], : SIZE[0]]
        picture = (250 * np.exp(-((x - u) ** 2 + (y - v) ** 2) / 18)).astype(np.uint8)
        shown = cv2.remap(picture, *rectification(upright, taken), cv2.INTER_LINEAR).astype(float)
        weight = np.where(shown > 60, shown, 0)
        rows, columns = np.mgrid[: shown.shape[0], : shown.shape[1]]
        found = np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()
        assert np.allclose(found, project(upright, np.array([point]))[0], atol=0.3)


def test_the_upright_camera_looks_the_same_way_and_stands_straight() -> None:
    upright = rectified(tilted(), 1.0)
    assert np.allclose(upright.rotation[2], tilted().rotation[2])
    assert upright.rotation[0, 2] == pytest.approx(0.0)
    assert upright.rotation[1, 2] < 0
    assert np.linalg.det(upright.rotation) == pytest.approx(1.0)


def test_nothing_that_the_video_shows_is_lost() -> None:
    upright = rectified(tilted(), 1.0)
    maps = rectification(upright, tilted())
    everything = cv2.remap(np.full((SIZE[1], SIZE[0]), 255, np.uint8), *maps, cv2.INTER_LINEAR)
    share = (everything > 0).sum() / (SIZE[0] * SIZE[1])
    assert share > 0.95


def test_cameras_that_cannot_be_turned_stay_as_they_are() -> None:
    for camera in (tilted(pitch=1.5), tilted(model="cylinder"), replace(tilted(), source=None)):
        assert rectified(camera, 1.0) is camera


def film(path: Path) -> None:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25, SIZE)
    for level in (40, 120, 200):
        writer.write(np.full((SIZE[1], SIZE[0], 3), level, np.uint8))
    writer.release()


def test_a_rectified_room_plays_the_frames_of_its_videos(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film(tmp_path / "cam.avi")
    room_file.save(Room("room", {"cam": tilted()}), tmp_path / "room.yaml")
    output = tmp_path / "other/upright.yaml"
    assert main(["room", "rectify", str(tmp_path / "room.yaml"), "--scale", "0.5", "-o", str(output)]) == 0
    camera = room_file.load(output).cameras["cam"]
    assert f"cam {camera.size[0]}x{camera.size[1]} px" in capsys.readouterr().out
    assert camera.source is not None
    params = {**camera.source.params, "path": output.parent / str(camera.source.params["path"])}
    stage = RectifiedVideo(Context.serving(camera, name="camera/cam"), **params)
    stage.setup()
    frames = list(stage.process())
    stage.close()
    assert [frame.header[1:3] for frame in frames] == [(k, k * 40_000_000) for k in range(3)]
    assert {frame.pixels.shape for frame in frames} == {(camera.size[1], camera.size[0], 3)}
    assert [round(float(np.median(frame.pixels)), -1) for frame in frames] == [40, 120, 200]


def test_templates_have_the_areas_of_the_new_pictures(tmp_path: Path) -> None:
    film(tmp_path / "cam.avi")
    red = Target("red", 0.05, area={"cam": (8.0, 100.0), "other": (4.0, 40.0)})
    cameras = {"cam": tilted(), "other": replace(tilted(), name="other", source=None)}
    room_file.save(Room("room", cameras, targets={"red": red}), tmp_path / "room.yaml")
    output = tmp_path / "upright.yaml"
    assert main(["room", "rectify", str(tmp_path / "room.yaml"), "--scale", "0.5", "-o", str(output)]) == 0
    assert room_file.load(output).targets["red"].area == {"cam": (2.0, 25.0), "other": (4.0, 40.0)}


def test_a_room_without_anything_to_turn_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room_file.save(Room("room", {"cam": replace(tilted(), source=None)}), tmp_path / "room.yaml")
    command = ["room", "rectify", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "upright.yaml")]
    assert main(command) == 2
    assert "no pinhole or fisheye camera with a video" in capsys.readouterr().err
    assert main([*command, "--scale", "3"]) == 2
    assert not (tmp_path / "upright.yaml").exists()

"""`calibrate check` by tracking data: which camera moved, when, and what only looks like that."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.tools.calibrate.checked import CAMERAS, GLOWBALLS, needs_recordings, room_file, turned

from followspot.cli.main import main
from followspot.geometry import project
from followspot.messages import Array
from followspot.room_file import load, save
from followspot_calibrate.check.agreement import bias


def tracking_run(path: Path, pixel_of: Callable[[Array, Array], Array], frames: int = 240) -> str:
    """A run's output: a target on its way, and blobs; pixel_of: times (N,), points (N, 3) -> (N, C, 2) px."""
    time = np.arange(frames) / 30
    xyz = np.stack([np.cos(time * 2), np.sin(time * 3), 1 + 0.5 * np.sin(time)], axis=1)
    tracks = ["frame,time,object,state,x,y,z"]
    blobs = ["frame,time,camera,target,u,v,area,similarity"]
    for frame, (pixel, place) in enumerate(zip(pixel_of(time, xyz), xyz, strict=True)):
        tracks.append(f"{frame},{time[frame]:.9f},red,tracked," + ",".join(f"{x:.6f}" for x in place))
        for camera, (u, v) in zip(CAMERAS, pixel, strict=True):
            blobs.append(f"{frame},{time[frame]:.9f},{camera.name},red,{u:.3f},{v:.3f},40,1.0")
    run = path / "run"
    run.mkdir()
    (run / "tracks.csv").write_text("\n".join(tracks) + "\n")
    (run / "blobs.csv").write_text("\n".join(blobs) + "\n")
    return str(run)


def noisy_images(xyz: Array) -> Array:
    pixel = np.stack([project(camera, xyz) for camera in CAMERAS], axis=1)
    return pixel + np.random.default_rng(1).normal(0, 0.4, pixel.shape)


def test_bias_is_a_shift_that_stands_out_from_the_scatter() -> None:
    random = np.random.default_rng(0)
    shift = np.array([1.5, -2.0]) + random.normal(0, 0.3, (200, 2))
    assert bias(shift) == pytest.approx(2.5, abs=0.1)
    assert bias(random.normal([1.5, 0], 3, (200, 2))) == 0.0


def test_tracking_data_tell_which_camera_moved_and_when(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def pixel_of(time: Array, xyz: Array) -> Array:
        pixel = noisy_images(xyz)
        pixel[time >= 5, 1] += [3.0, -2.0]
        return pixel

    room, run = room_file(tmp_path, CAMERAS), tracking_run(tmp_path, pixel_of)
    assert main(["calibrate", "check", "--room", room, "--run", run, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [camera["camera"] for camera in found["tracks"]["cameras"] if camera["suspect"]] == ["cam1"]
    changes = {one["camera"]: one["change"] for one in found["drift"] if one["change"]}
    assert list(changes) == ["cam1"]
    assert changes["cam1"]["at"] == pytest.approx(5, abs=0.1)
    np.testing.assert_allclose(changes["cam1"]["by_px"], [3, -2], atol=0.3)
    assert "moved at 5.0 s: calibrate wand again for cam1" in found["verdict"]
    assert "cam1: moved at 5.0 s" in (tmp_path / "room.check.html").read_text().replace("</b>", "")


def test_a_camera_that_moved_far_is_not_taken_to_see_other_things_since(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def pixel_of(time: Array, xyz: Array) -> Array:
        pixel = noisy_images(xyz)
        pixel[time >= 5, 1] += [12.0, -8.0]
        return pixel

    room, run = room_file(tmp_path, CAMERAS), tracking_run(tmp_path, pixel_of)
    assert main(["calibrate", "check", "--room", room, "--run", run, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    changes = {one["camera"]: one["change"] for one in found["drift"] if one["change"]}
    assert list(changes) == ["cam1"]
    assert changes["cam1"]["at"] == pytest.approx(5, abs=0.1)
    np.testing.assert_allclose(changes["cam1"]["by_px"], [12, -8], atol=0.5)


def test_tracking_data_tell_a_slow_drift(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def pixel_of(time: Array, xyz: Array) -> Array:
        pixel = noisy_images(xyz)
        pixel[:, 3] += np.outer(time, [0.5, 0.0])
        return pixel

    room, run = room_file(tmp_path, CAMERAS), tracking_run(tmp_path, pixel_of)
    assert main(["calibrate", "check", "--room", room, "--run", run, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    change = found["drift"][3]["change"]
    assert change["at"] is None
    np.testing.assert_allclose(change["by_px"], [4, 0], atol=0.4)
    assert any("cam3 drifts" in text for text in found["warnings"])


def test_light_that_follows_a_target_does_not_look_like_a_camera_that_moved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def pixel_of(time: Array, xyz: Array) -> Array:
        pixel = noisy_images(xyz)
        covered = (time > 2) & (time < 4)
        pixel[covered, 0] += np.random.default_rng(2).normal([5, 0], 8, (int(covered.sum()), 2))
        return pixel

    room, run = room_file(tmp_path, CAMERAS), tracking_run(tmp_path, pixel_of)
    assert main(["calibrate", "check", "--room", room, "--run", run]) == 0
    assert "good" in capsys.readouterr().out


@needs_recordings
@pytest.mark.thorough
def test_a_turned_camera_is_found_by_tracking_the_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room, calibration = str(tmp_path / "room.yaml"), str(GLOWBALLS / "calibration.json")
    assert main(["room", "import", calibration, "--videos", str(GLOWBALLS / "dev1"), "-o", room]) == 0
    assert main(["calibrate", "targets", "--room", room, "--clips", str(GLOWBALLS / "templates")]) == 0
    knocked = load(room)
    save(replace(knocked, cameras={**knocked.cameras, "cam3": turned(knocked.cameras["cam3"], 0.5)}), room)
    capsys.readouterr()
    graph = str(Path(__file__).parents[3] / "graphs/glowballs.yaml")
    command = ["calibrate", "check", "--room", room, "--track", "--graph", graph, "--frames", "90"]
    assert main([*command, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [camera["camera"] for camera in found["tracks"]["cameras"] if camera["suspect"]] == ["cam3"]

"""`calibrate check` by points: how good a room file is now, and which camera is to blame."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.full_disk import full_disk
from tests.tools.calibrate.checked import CAMERAS, GLOWBALLS, needs_recordings, room_file, turned
from tests.tools.calibrate.rooms import made_room

from followspot import Camera
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.messages import Array
from followspot.room_file import load, save
from followspot_calibrate.check.agreement import agreement, typical_error, usual_limits
from followspot_calibrate.check.findings import Findings
from followspot_calibrate.check.lengths import MeasuredLength, measured_length


def seen_by(cameras: Sequence[Camera], rows: int = 200, seed: int = 0) -> tuple[Array, Array]:
    """Points (N, 3) m and what cameras see of them, with noise: (N, C, 2) px."""
    random = np.random.default_rng(seed)
    points = random.uniform([-1.2, -1.2, 0.2], [1.2, 1.2, 1.8], (rows, 3))
    pixel = np.stack([project(camera, points) for camera in cameras], axis=1)
    return points, pixel + random.normal(0, 0.3, pixel.shape)


def points_file(path: Path, pixel: Array, frame: Array | None = None, label: Array | None = None) -> str:
    frame = np.arange(len(pixel)) if frame is None else frame
    label = np.zeros(len(pixel), int) if label is None else label
    lines = ["frame,camera,u,v,point"]
    for row, camera in np.argwhere(np.isfinite(pixel[..., 0])):
        u, v = pixel[row, camera]
        lines.append(f"{frame[row]},{camera},{u:.4f},{v:.4f},{label[row]}")
    (path / "points.csv").write_text("\n".join(lines) + "\n")
    return str(path / "points.csv")


def test_cameras_that_agree_are_good(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, pixel = seen_by(CAMERAS)
    room, points = room_file(tmp_path, CAMERAS), points_file(tmp_path, pixel)
    assert main(["calibrate", "check", "--room", room, "--points", points]) == 0
    assert "good: 5 cameras agree" in capsys.readouterr().out
    page = (tmp_path / "room.check.html").read_text()
    assert all(f"<h2>{camera.name}: points</h2>" in page for camera in CAMERAS)


@pytest.mark.parametrize("moved", range(5))
@pytest.mark.parametrize("degrees", [0.4, 5.0])
def test_the_camera_that_moved_is_named_and_no_other(moved: int, degrees: float) -> None:
    real = [turned(c, degrees) if n == moved else c for n, c in enumerate(CAMERAS)]
    _, pixel = seen_by(real)
    found = agreement(CAMERAS, pixel, np.arange(200), usual_limits(CAMERAS, None), typical_error)
    assert found.suspects == (moved,)
    assert not found.at_odds
    others = np.delete(found.score, moved)
    assert others.max() < 0.8


def test_two_cameras_that_moved_are_both_named() -> None:
    real = [turned(c, {1: 1.0, 3: -2.0}.get(n, 0.0)) for n, c in enumerate(CAMERAS)]
    _, pixel = seen_by(real)
    found = agreement(CAMERAS, pixel, np.arange(200), usual_limits(CAMERAS, None), typical_error)
    assert found.suspects == (1, 3)


def test_a_camera_that_moved_during_the_last_third_is_named() -> None:
    _, pixel = seen_by(CAMERAS)
    _, after = seen_by([turned(c, 0.6) if n == 2 else c for n, c in enumerate(CAMERAS)])
    pixel[140:] = after[140:]
    found = agreement(CAMERAS, pixel, np.arange(200), usual_limits(CAMERAS, None), typical_error)
    assert found.suspects == (2,)


def test_of_three_cameras_at_odds_none_is_blamed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    three = CAMERAS[:3]
    _, pixel = seen_by([three[0], turned(three[1], 2.0), three[2]])
    room, points = room_file(tmp_path, three), points_file(tmp_path, pixel)
    assert main(["calibrate", "check", "--room", room, "--points", points, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["good"]
    assert "the cameras do not agree with each other" in found["verdict"]
    assert not any(camera["suspect"] for camera in found["points"]["cameras"])


def test_gross_errors_are_counted_and_blame_no_camera() -> None:
    room = made_room(5, 400, outliers=0.15, noise=0.3, missing=0.2)
    found = agreement(
        room.cameras, room.sightings.pixel, np.arange(400), usual_limits(room.cameras, None), typical_error
    )
    assert found.suspects == ()
    known = np.isfinite(found.length)
    share = (found.gross & known).sum(axis=0) / known.sum(axis=0)
    assert (share > 0.05).all()
    assert (share < 0.3).all()


def test_a_camera_that_shares_too_little_is_told_and_not_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, pixel = seen_by(CAMERAS)
    pixel[11:, 4] = np.nan
    room, points = room_file(tmp_path, CAMERAS), points_file(tmp_path, pixel)
    assert main(["calibrate", "check", "--room", room, "--points", points, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert "cam4 shares 11 points with two other cameras, too few to be checked" in found["warnings"][0]
    assert found["points"]["cameras"][4]["judged_px"] is None


@pytest.mark.parametrize(("flipped", "missing"), [([1], 0.0), ([0, 1], 0.5)])
def test_flipped_points_are_told_in_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], flipped: list[int], missing: float
) -> None:
    """Of cameras that cannot be judged, as the others agree about too few points, no number is told."""
    _, pixel = seen_by(CAMERAS)
    pixel[..., flipped] = np.subtract(CAMERAS[0].size, 1)[flipped] - pixel[..., flipped]
    pixel[np.random.default_rng(1).random(pixel.shape[:2]) < missing] = np.nan
    room, points = room_file(tmp_path, CAMERAS), points_file(tmp_path, pixel)
    assert main(["calibrate", "check", "--room", room, "--points", points]) == 1
    told = capsys.readouterr().out
    assert "beyond the limit: cam0: its sightings " in told
    assert "nan" not in told


def test_a_page_that_a_full_disk_cuts_short_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, pixel = seen_by(CAMERAS)
    words = [
        "calibrate",
        "check",
        "--room",
        room_file(tmp_path, CAMERAS),
        "--points",
        points_file(tmp_path, pixel),
    ]
    with full_disk(1000):
        assert main(words) == 1
    assert f"{tmp_path / 'room.check.html'} cannot be written: File too large" in capsys.readouterr().err


def test_epipolar_errors_point_to_the_pairs_of_the_camera_that_moved() -> None:
    _, pixel = seen_by([turned(c, 1.5) if n == 2 else c for n, c in enumerate(CAMERAS)])
    found = agreement(CAMERAS, pixel, np.arange(200), usual_limits(CAMERAS, None), typical_error)
    np.testing.assert_array_equal(found.epipolar, found.epipolar.T)
    others = np.delete(np.delete(found.epipolar, 2, axis=0), 2, axis=1)
    assert np.nanmax(others) < 0.6 < np.nanmax(found.epipolar[2])
    assert (found.shared + 1000 * np.eye(5) >= 200).all()


@pytest.mark.parametrize(("true", "code"), [(0.5, 0), (0.48, 1)])
def test_a_known_length_is_measured_in_mm(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], true: float, code: int
) -> None:
    random = np.random.default_rng(4)
    middle = random.uniform([-1, -1, 0.5], [1, 1, 1.5], (60, 3))
    half = random.normal(0, 1, (60, 3))
    half *= 0.25 / np.linalg.norm(half, axis=1, keepdims=True)
    ends = np.concatenate([middle - half, middle + half])
    pixel = np.stack([project(camera, ends) for camera in CAMERAS], axis=1)
    pixel[7] += 100.0  # a reflection that all cameras agree about
    frame, label = np.tile(np.arange(60), 2), np.repeat([0, 1], 60)
    room, points = room_file(tmp_path, CAMERAS), points_file(tmp_path, pixel, frame, label)
    command = ["calibrate", "check", "--room", room, "--points", points, "--length", str(true), "--json"]
    assert main(command) == code
    found = json.loads(capsys.readouterr().out)
    assert found["length"]["mean_mm"] == pytest.approx(500, abs=0.1)
    assert found["length"]["sigma_mm"] < 0.5
    assert found["length"]["count"] >= 59 - 1
    assert any("scale is off by +4.2 %" in text for text in found["failures"]) == bool(code)
    assert ("the known length is right within 0." in found["verdict"]) == (not code)


def test_of_several_failures_the_verdict_names_the_first() -> None:
    _, pixel = seen_by(CAMERAS[:3])
    odds = pixel + np.random.default_rng(1).normal(0, 6.0, pixel.shape)
    points = agreement(CAMERAS[:3], odds, np.arange(200), usual_limits(CAMERAS[:3], None), typical_error)
    length = MeasuredLength(0.5, 520.0, 0.1, 60)
    found = Findings(CAMERAS[:3], points, length=length)
    assert len(found.failures) == 2
    assert found.blamed == []
    assert found.verdict == f"not good: {found.failures[0]}"
    assert "do not agree with each other" in found.verdict


def test_a_length_without_a_second_point_is_refused() -> None:
    points = np.zeros((30, 3))
    with pytest.raises(FollowspotError, match=r"0 frames show points 0 and 1 .* 10 needed"):
        measured_length(points, np.arange(30), np.zeros(30, int), 0.5)


def test_mistakes_name_the_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = room_file(tmp_path, CAMERAS)
    one = room_file(tmp_path, CAMERAS[:1], "one.yaml")
    for options, said in [
        ([], "give --points, --run, --track or --against"),
        (["--run", str(tmp_path), "--length", "1"], "--length is measured on points"),
        (["--run", str(tmp_path)], "sinks.csv"),
        (["--against", room, "--limit", "-1"], "--limit -1 is not positive"),
        (["--against", one], "share 1 cameras"),
        (["--against", str(tmp_path / "none.toml")], "none.toml cannot be read"),
    ]:
        assert main(["calibrate", "check", "--room", room, *options]) == 2
        assert said in capsys.readouterr().err


@needs_recordings
def test_glowballs_wand_finds_its_own_calibration_good_and_a_turned_camera_bad(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room, points = str(tmp_path / "room.yaml"), str(GLOWBALLS / "wand/points.csv")
    videos = str(GLOWBALLS / "dev1")
    calibration = str(GLOWBALLS / "calibration.json")
    assert main(["room", "import", calibration, "--videos", videos, "-o", room]) == 0
    assert main(["calibrate", "check", "--room", room, "--points", points]) == 0
    knocked = load(room)
    cameras = {**knocked.cameras, "cam3": turned(knocked.cameras["cam3"], 0.5)}
    save(replace(knocked, cameras=cameras), room)
    capsys.readouterr()
    assert main(["calibrate", "check", "--room", room, "--points", points, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [camera["camera"] for camera in found["points"]["cameras"] if camera["suspect"]] == ["cam3"]

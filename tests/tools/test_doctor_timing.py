"""`followspot doctor --cameras`: how far apart live cameras take the pictures of one moment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.plugins.cameras.recordings import SIZE, record

from followspot import Camera, Room
from followspot.room import StageUse
from followspot.room_file import save
from followspot_doctor.checks.timing import findings, timing
from followspot_doctor.spread import spread_of

START = 1_700_000_000_000_000_007


def pictures(rate: float, late: float = 0.0, jitter: float = 0.0, count: int = 90) -> np.ndarray:
    """Capture times, ns. late, jitter: ms."""
    noise = np.random.default_rng(0).normal(0, jitter, count) if jitter else np.zeros(count)
    return START + np.round((np.arange(count) / rate * 1e3 + late + noise) * 1e6).astype(np.int64)


def test_cameras_in_step_have_no_spread() -> None:
    spread = spread_of({name: pictures(60) for name in "abc"})
    assert spread is not None
    assert (spread.usual, spread.most) == (0, 0)
    assert spread.cameras["b"].rate == pytest.approx(60, abs=0.01)
    assert all(finding.state == "ok" for finding in findings(spread))


def test_the_camera_that_is_off_is_named_with_the_remedy() -> None:
    spread = spread_of({"a": pictures(30), "b": pictures(30, late=0.5), "c": pictures(30, late=-7.25)})
    assert spread is not None
    assert {name: round(one.late, 3) for name, one in spread.cameras.items()} == {
        "a": 0,
        "b": 0.5,
        "c": -7.25,
    }
    assert spread.usual == pytest.approx(7.75, abs=0.01)
    told = {finding.subject: finding for finding in findings(spread)}
    assert [name for name, finding in told.items() if finding.state != "ok"] == ["c", "timing of cameras"]
    assert "7.25 ms earlier than the others" in told["c"].text
    assert "calibrate clocks" in told["c"].remedy


def test_of_two_cameras_the_second_is_compared_with_the_first() -> None:
    spread = spread_of({"left": pictures(30), "right": pictures(30, late=-7.25)})
    assert spread is not None
    told = {finding.subject: finding for finding in findings(spread)}
    assert told["left"].text == "30 pictures/s; right is compared with it"
    assert "7.25 ms earlier than left" in told["right"].text
    assert (told["left"].state, told["right"].state) == ("ok", "warning")


def test_jitter_is_that_of_the_camera_that_has_it() -> None:
    times = {"a": pictures(50), "b": pictures(50), "c": pictures(50, jitter=1.0, count=400)[:90]}
    spread = spread_of(times)
    assert spread is not None
    assert spread.cameras["c"].jitter == pytest.approx(1.0, rel=0.3)
    assert spread.cameras["a"].jitter == 0


def test_a_faster_camera_is_compared_at_the_moments_of_the_slower() -> None:
    spread = spread_of({"slow": pictures(30), "fast": pictures(120, late=1.0, count=360)})
    assert spread is not None
    assert spread.cameras["fast"].late == pytest.approx(1.0, abs=0.01)
    assert spread.cameras["fast"].rate == pytest.approx(120, abs=0.1)


def test_the_rate_is_that_of_all_pictures_not_of_most_intervals() -> None:
    """A camera that looks for triggers 25 times a second takes 20 pictures a second 40 or 80 ms apart."""
    ticks = np.arange(200)
    taken = START + ticks[ticks % 5 != 4] * 40_000_000
    spread = spread_of({"a": taken, "b": taken})
    assert spread is not None
    assert spread.cameras["a"].rate == pytest.approx(20, rel=0.01)


def test_pictures_just_before_the_first_common_one_count() -> None:
    """One camera is a nanosecond earlier, so its first picture is before the other's."""
    spread = spread_of({"a": pictures(20, count=10), "b": pictures(20, count=10) - 1})
    assert spread is not None
    assert spread.most < 0.001


def test_cameras_that_never_gave_pictures_together_have_no_spread() -> None:
    assert spread_of({"a": pictures(30), "b": pictures(30) + 10**12}) is None
    assert spread_of({"a": pictures(30), "b": pictures(30, count=3)}) is None
    assert spread_of({"a": pictures(30)}) is None


def test_live_cameras_of_a_room_are_watched_together(tmp_path: Path) -> None:
    record(tmp_path / "a.avi", frames=40, fps=50)
    eye = np.eye(3)

    def camera(name: str, uses: str, **params: float) -> Camera:
        source = StageUse(uses, {"path": "a.avi", **params})
        return Camera(
            name,
            "color",
            SIZE,
            50 * eye + [[0, 0, 32], [0, 0, 24], [0, 0, -49]],
            np.zeros(5),
            eye,
            eye[0],
            source=source,
        )

    live = [camera(name, "cameras.playback") for name in "ab"]
    live.append(camera("c", "cameras.playback", start_time=0.006))
    for cameras in (live[:1], [*live, camera("d", "cameras.video")]):
        save(Room("r", {one.name: one for one in cameras}), tmp_path / "room.yaml")
        told = {finding.subject: finding for finding in timing(str(tmp_path / "room.yaml"), 0.5)}
        if len(cameras) == 1:
            assert "nothing to compare" in told["timing of cameras"].text
    assert list(told) == ["a", "b", "c", "timing of cameras"]
    assert told["a"].state == "ok"
    assert "50 pictures/s" in told["a"].text
    assert told["c"].state == "warning"
    assert "6 ms later than the others" in told["c"].text

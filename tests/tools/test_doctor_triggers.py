"""`followspot doctor --cameras` on machine-vision cameras: in free run, and triggered by software."""

from __future__ import annotations

import queue
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from followspot import Camera, Room
from followspot.room import StageUse, Sync
from followspot.room_file import save
from followspot_cameras.genicam.camera import Picture
from followspot_cameras.genicam.camera_clock import Reading
from followspot_doctor.checks.timing import timing
from followspot_doctor.finding import Finding

pytest.importorskip("viva_genicam", reason="viva-genicam is not installed")
from followspot_cameras.genicam import stage as genicam_stage

SIZE = (64, 48)
PERIOD = 50_000_000
"""Of triggers and of free cameras, ns."""


class Clocked:
    """A camera whose clock is read exactly, and whose pictures are `late`, ns, after whole periods.

    triggered: it takes them when it is told to; else at each period.
    """

    largest_identifier = 0
    slow = 0.0
    """Time to connect, s."""

    def __init__(self, late: int, *, triggered: bool) -> None:
        self.late, self.triggered, self.identifier = late, triggered, 0
        self.moments: queue.Queue[int] = queue.Queue()
        self.last = 1 << 62
        """Moment of the last picture; none is taken before the start."""

    def names(self) -> tuple[str, ...]:
        return ()

    def feature(self, name: str) -> None: ...

    def read(self, name: str) -> str:
        raise ValueError(name)

    def start(self) -> None:
        time.sleep(self.slow)
        self.last = time.time_ns() // PERIOD

    def overruns(self) -> int:
        return 0

    def close(self) -> None: ...

    def read_clock(self) -> Reading:
        now = time.monotonic_ns()
        return Reading(now, now, now)

    def execute(self, name: str) -> None:
        assert name == "TriggerSoftware"
        if (moment := time.time_ns() // PERIOD) > self.last:
            self.moments.put(moment)

    def next(self, timeout: float) -> Picture | None:
        if self.triggered:
            try:
                moment = self.moments.get(timeout=timeout)
            except queue.Empty:
                return None
        else:
            self.last = moment = max(self.last + 1, time.time_ns() // PERIOD)
            time.sleep(max(0, moment * PERIOD - time.time_ns()) / 1e9)
        self.identifier += 1
        taken = moment * PERIOD + self.late - (time.time_ns() - time.monotonic_ns())
        arrival = max(time.monotonic_ns(), taken)
        return Picture(np.zeros(SIZE[0] * SIZE[1], "u1"), SIZE, "Mono8", self.identifier, taken, arrival)


def watched(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    sync: Sync | None,
    late: dict[str, int],
    times: Sequence[float] = (0.7, 3.0, 5.5),
) -> dict[str, Finding]:
    """What doctor tells, watching for longer if the computer is so busy that few pictures came."""
    monkeypatch.setattr(genicam_stage, "trigger_features", lambda *given: {})
    monkeypatch.setattr(
        genicam_stage, "connected", lambda name, *_: Clocked(late[name], triggered=sync is not None)
    )
    eye, matrix = np.eye(3), np.array([[50.0, 0, 32], [0, 50, 24], [0, 0, 1]])
    cameras = {
        name: Camera(
            name,
            "infrared",
            SIZE,
            matrix,
            np.zeros(5),
            eye,
            eye[0],
            source=StageUse("cameras.genicam", {"camera": name}),
        )
        for name in late
    }
    save(Room("r", cameras, sync=sync), folder / "room.yaml")
    for seconds in times:
        told = {one.subject: one for one in timing(str(folder / "room.yaml"), seconds)}
        if late.keys() <= told.keys():
            break
    return told


@pytest.mark.parametrize("sync", [None, Sync("software", rate=20.0)])
def test_the_camera_that_is_off_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sync: Sync | None
) -> None:
    """Also where pictures of one trigger are given one capture time in a run."""
    told = watched(tmp_path, monkeypatch, sync, {"left": 300_000, "middle": 500_000, "right": 9_000_000})
    assert {name: one.state for name, one in told.items()} == {
        "left": "ok",
        "middle": "ok",
        "right": "warning",
        "timing of cameras": "warning",
    }
    assert "8.5 ms later than the others" in told["right"].text
    assert "trigger the cameras together" in told["right"].remedy


def test_cameras_are_watched_from_when_all_of_them_send_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One needs longer to connect than the cameras are watched."""
    monkeypatch.setattr(Clocked, "slow", 1.0)
    told = watched(tmp_path, monkeypatch, None, {"left": 0, "right": 0}, times=(0.7,))
    assert told["timing of cameras"].state == "ok"

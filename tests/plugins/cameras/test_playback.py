"""A recording as a live camera."""

import threading
import time
from itertools import islice, pairwise
from pathlib import Path

import pytest
from tests.plugins.cameras.recordings import context, numbers, record

from followspot.testing import check_stage
from followspot_cameras.video.playback import Playback


class Waits(threading.Event):
    """Notes how long it is asked to wait, and does not."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[float] = []

    def wait(self, timeout: float | None = None) -> bool:
        self.asked.append(timeout or 0.0)
        return self.is_set()


def playback(path: Path, **params: object) -> tuple[Playback, Waits]:
    stage = Playback(context(), path=path, **params)
    stage.setup()
    waits = Waits()
    stage.__dict__["stopped"] = waits
    return stage, waits


def test_stage_keeps_the_promises_of_stages() -> None:
    check_stage(Playback)
    assert Playback.live


def test_frames_are_those_of_the_recording_with_its_times(tmp_path: Path) -> None:
    stage, _ = playback(record(tmp_path / "a.mkv", frames=4))
    frames = list(stage.process())
    assert [numbers(frame.pixels) for frame in frames] == [0, 1, 2, 3]
    assert [frame.header.time for frame in frames] == [n * 1_000_000_000 // 30 for n in range(4)]


def test_a_loop_goes_on_with_times_and_numbers(tmp_path: Path) -> None:
    stage, waits = playback(record(tmp_path / "a.mkv", frames=3), loop=True, start_frame=1)
    frames = list(islice(stage.process(), 6))
    assert [numbers(frame.pixels) for frame in frames] == [1, 2, 1, 2, 1, 2]
    assert [frame.header.seq for frame in frames] == [1, 2, 3, 4, 5, 6]
    steps = [later.header.time - sooner.header.time for sooner, later in pairwise(frames)]
    assert all(abs(step - 1_000_000_000 / 30) < 2 for step in steps)
    assert stage.length() is None
    waits.set()
    assert list(stage.process()) == [], "closed, it does not begin again"


@pytest.mark.parametrize("speed", [1.0, 0.25])
def test_each_frame_waits_until_it_is_due(tmp_path: Path, speed: float) -> None:
    """500 s a frame, so that the time which the test itself takes does not matter."""
    stage, waits = playback(record(tmp_path / "a.mkv", frames=4), fps=1 / (500 * speed), speed=speed)
    assert len(list(stage.process())) == 4
    assert [round(wait / 100) for wait in waits.asked] == [0, 5, 10, 15]
    assert all(later > earlier for earlier, later in pairwise(waits.asked))


def test_closing_ends_the_waiting_from_another_thread(tmp_path: Path) -> None:
    stage = Playback(context(), path=record(tmp_path / "a.mkv", frames=4), fps=0.002)
    stage.setup()
    frames = stage.process()
    next(frames)
    closer = threading.Timer(0.05, stage.close)
    closer.start()
    assert list(frames) == []
    closer.join()


@pytest.mark.parametrize(
    ("loop", "rounds", "speed"), [(False, 0, 1.0), (True, 0, 1.0), (True, 7, 1.0), (True, 7, 2.0)]
)
def test_a_worker_that_is_started_again_goes_on_at_the_frame_that_is_due(
    tmp_path: Path, loop: bool, rounds: int, speed: float
) -> None:
    """500 s a frame: between two and three frames of a round of four have been shown."""
    path = record(tmp_path / "a.mkv", frames=4)
    stage, waits = playback(path, fps=1 / 500, loop=loop, speed=speed)
    assert stage.state() is None
    next(iter(stage.process()))
    state = stage.state()
    assert state is not None
    stage, waits = playback(path, fps=1 / 500, loop=loop, speed=speed)
    stage.restore({**state, "began": time.monotonic() - 500 * (4 * rounds + 2.5) / speed})
    frame = next(iter(stage.process()))
    assert numbers(frame.pixels) == 3
    assert frame.header.time == (4 * rounds + 3) * 500_000_000_000
    assert frame.header.seq == 4 * rounds + 3
    assert round(waits.asked[0] * speed / 50) == 5


def test_at_another_speed_it_goes_on_where_it_is(tmp_path: Path) -> None:
    stage, _ = playback(record(tmp_path / "a.mkv", frames=4), fps=1 / 500)
    next(iter(stage.process()))
    state = stage.state()
    assert state is not None
    stage, _ = playback(tmp_path / "a.mkv", fps=1 / 500, speed=2.0)
    stage.restore({**state, "began": time.monotonic() - 1250})
    assert next(iter(stage.process())).header.time == 3 * 500_000_000_000


@pytest.mark.parametrize(("clock", "left"), [(-50.0, 200), (3600.0, 250), (-3600.0, 250)])
def test_another_computer_goes_by_its_wall_clock_unless_that_cannot_be_right(
    tmp_path: Path, clock: float, left: int
) -> None:
    """clock: of the first computer against the second, s: it was away for 50 s, or that clock is wrong."""
    stage, _ = playback(record(tmp_path / "a.mkv", frames=4), fps=1 / 500)
    next(iter(stage.process()))
    state = stage.state()
    assert state is not None
    stage, waits = playback(tmp_path / "a.mkv", fps=1 / 500)
    stage.restore(
        {**state, "computer": "another", "began": 1e9, "played": 1250.0, "now": time.time() + clock}
    )
    assert next(iter(stage.process())).header.time == 3 * 500_000_000_000
    assert round(waits.asked[0] / 10) == left / 10

"""Pictures of one trigger have one capture time, however their clocks jitter."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from itertools import islice
from typing import Any

import numpy as np
import pytest
from tests.plugins.cameras.recordings import SIZE, context

from followspot import Context, Room
from followspot.room import Sync
from followspot_cameras.genicam.camera import Picture
from followspot_cameras.genicam.trigger_times import WINDOW, TriggerTimes, trigger_times

pytest.importorskip("viva_genicam", reason="viva-genicam is not installed")
from followspot_cameras.genicam import stage as genicam_stage
from followspot_cameras.genicam.stage import Genicam

RATE = 40.0
PERIOD = 25_000_000
MOMENT = 1_700_000_000_000_000_000
"""Of trigger 0: a whole period since 1970, ns."""
DATA = np.zeros(SIZE[0] * SIZE[1], "u1")


def silent(text: str) -> None:
    raise AssertionError(text)


def moments(numbers: Any, late: Any, rate: float = RATE, *, exact: bool, shared: bool = True) -> list[int]:
    """Of pictures that are `late` after their triggers, s: trigger of each by its time, by 0 the first."""
    times = TriggerTimes(rate, silent, shared=shared)
    told = MOMENT + np.round((np.asarray(numbers) / rate + np.asarray(late)) * 1e9).astype(np.int64)
    return [
        times.capture_time(int(n) + 70_000, int(t), exact=exact) for n, t in zip(numbers, told, strict=True)
    ]


@pytest.mark.parametrize("late", [-0.006, 0.0, 0.0003, 0.012, 0.018])
def test_a_picture_is_captured_at_its_trigger(late: float) -> None:
    for exact in (True, False):
        found = TriggerTimes(RATE, print, shared=True)
        times = [found.capture_time(n, MOMENT + n * PERIOD + int(late * 1e9), exact=exact) for n in range(50)]
        assert times == [MOMENT + n * PERIOD for n in range(50)]


def test_jitter_of_more_than_half_a_period_leaves_a_picture_with_its_trigger() -> None:
    random = np.random.default_rng(3)
    late = random.uniform(-0.012, 0.020, 2000)  # up to 0.64 periods off
    found = moments(np.arange(2000), late, exact=False)
    assert found[WINDOW:] == [MOMENT + n * PERIOD for n in range(WINDOW, 2000)]
    by_time = np.round((late * 1e9) / PERIOD)
    assert np.mean(by_time != 0) > 0.15  # what their times alone would say


def test_lost_pictures_do_not_move_the_others() -> None:
    random = np.random.default_rng(4)
    numbers = np.flatnonzero(random.random(600) > 0.3)
    found = moments(numbers, random.uniform(-0.01, 0.02, len(numbers)), exact=False)
    assert found[WINDOW:] == [MOMENT + int(n) * PERIOD for n in numbers[WINDOW:]]


def test_pictures_that_a_busy_computer_takes_late_keep_their_triggers() -> None:
    late = np.full(300, 0.004)
    late[100:108] = np.linspace(0.3, 0.05, 8)  # they waited, and came at once
    assert moments(np.arange(300), late, exact=False) == [MOMENT + n * PERIOD for n in range(300)]


@pytest.mark.parametrize(("exact", "needed"), [(True, 0), (False, WINDOW // 2 + 1)])
def test_a_trigger_that_the_camera_missed_is_noticed(exact: bool, needed: int) -> None:
    """Its numbers go on rising by one, and its pictures are a period later from then on."""
    late = np.full(200, 0.002)
    late[100:] += 1 / RATE
    found = moments(np.arange(200), late, exact=exact)
    assert found[:100] == [MOMENT + n * PERIOD for n in range(100)]
    assert found[100 + needed :] == [MOMENT + (n + 1) * PERIOD for n in range(100 + needed, 200)]


def test_two_pictures_of_one_trigger_keep_their_order() -> None:
    late = np.full(10, 0.002)
    late[5:] -= 1 / RATE
    found = moments(np.arange(10), late, exact=True)
    assert found[4:7] == [MOMENT + 4 * PERIOD, MOMENT + 4 * PERIOD + 1, MOMENT + 5 * PERIOD]


def test_odd_rates_have_the_moments_of_the_commands() -> None:
    from followspot_cameras.genicam.triggers import next_moment

    rate, sent = 29.97, [MOMENT]
    for _ in range(200):
        sent.append(next_moment(sent[-1] + 1, rate))
    times = TriggerTimes(rate, silent, shared=True)
    found = [times.capture_time(n, at + 300_000, exact=True) for n, at in enumerate(sent[1:])]
    assert found == sent[1:]


def test_a_line_leaves_good_times_as_they_are_and_smooths_others() -> None:
    random = np.random.default_rng(5)
    late = random.uniform(-0.015, 0.015, 1000)
    true = MOMENT + 1_234_567 + np.arange(1000) * PERIOD
    kept = moments(np.arange(1000), late / 3 + 0.001234567, exact=True, shared=False)
    assert np.abs(np.array(kept) - true - late / 3 * 1e9).max() < 1000
    smooth = moments(np.arange(1000), late + 0.001234567, exact=False, shared=False)
    assert np.std(np.array(smooth)[WINDOW:] - true[WINDOW:]) < 0.35 * np.std(late * 1e9)


def test_a_camera_in_doubt_says_so_once() -> None:
    said: list[str] = []
    times = TriggerTimes(RATE, said.append, shared=True)
    for n in range(3 * WINDOW):
        times.capture_time(n, MOMENT + n * PERIOD + 18_000_000, exact=False)
    assert len(said) == 1
    assert "18.0 ms after their triggers" in said[0]
    assert "`match: time`" in said[0]


def test_rooms_without_a_rate_or_by_time_keep_the_times_of_clocks() -> None:
    assert trigger_times(None, silent) is None
    assert trigger_times(Sync("line", "cam0"), silent) is None
    assert trigger_times(Sync("software", rate=30.0, match="time"), silent) is None
    assert trigger_times(Sync("line", "cam0", 30.0), silent) is not None


class Triggered:
    """A camera whose pictures arrive late by chance; identifiers begin again, some pictures are lost."""

    largest_identifier = 65_535

    def __init__(self, seed: int, begin: int, lost: Callable[[int], bool]) -> None:
        self.random, self.begin, self.lost = np.random.default_rng(seed), begin, lost
        now = time.time_ns()
        self.zero = (now // PERIOD + 1) * PERIOD - now + time.monotonic_ns()
        self.trigger = -1

    def names(self) -> tuple[str, ...]:
        return ()

    def feature(self, name: str) -> None: ...

    def read(self, name: str) -> str:
        raise ValueError(name)

    def execute(self, name: str) -> None: ...

    def read_clock(self) -> None:
        return None

    def start(self) -> None: ...

    def overruns(self) -> int:
        return 0

    def close(self) -> None: ...

    def next(self, timeout: float) -> Picture:
        self.trigger += 1
        while self.lost(self.trigger):
            self.trigger += 1
        identifier = (self.begin + self.trigger - 1) % 65_535 + 1
        late = int(self.random.uniform(-14e6, 24e6))
        return Picture(DATA, SIZE, "Mono8", identifier, None, self.zero + self.trigger * PERIOD + late)


def frames(camera: Triggered, sync: Sync, monkeypatch: pytest.MonkeyPatch, count: int) -> Iterator[Any]:
    monkeypatch.setattr(genicam_stage, "connected", lambda *given: camera)
    monkeypatch.setattr(genicam_stage, "trigger_features", lambda *given: {})
    monkeypatch.setattr(genicam_stage, "firing", lambda *given: nullcontext())
    known = context("infrared", SIZE).room.cameras["cam3"]
    source = Genicam(Context.serving(known, Room(cameras={"cam3": known}, sync=sync), warn=print))
    return islice(source.process(), count)


@pytest.mark.parametrize(("match", "alike"), [("number", True), ("time", False)])
def test_two_cameras_whose_clocks_jitter_are_matched_by_number(
    monkeypatch: pytest.MonkeyPatch, match: Any, alike: bool
) -> None:
    """Pictures of one trigger, which is told by the fake's own count, have one capture time in both."""
    sync = Sync("software", rate=RATE, match=match)
    moment: list[dict[int, int]] = []
    for seed, begin in ((1, 65_400), (2, 7)):
        camera = Triggered(seed, begin, lambda n, seed=seed: n > 40 and (n + seed) % 17 in (0, 1))
        first = (time.time_ns() - time.monotonic_ns() + camera.zero) / PERIOD
        taken = {}
        for frame in frames(camera, sync, monkeypatch, 300):
            taken[camera.trigger + round(first)] = frame.header.time
        moment.append(taken)
    both = sorted(moment[0].keys() & moment[1].keys())
    assert len(both) >= 200
    apart = [abs(moment[0][n] - moment[1][n]) for n in both[WINDOW:]]
    assert (max(apart) == 0) is alike

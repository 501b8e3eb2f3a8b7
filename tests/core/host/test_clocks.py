"""Offsets between the clocks of hosts, and the correction of messages."""

from __future__ import annotations

import random
import time
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.control.clock_status import LIMIT_MS, ClockStatus, ClockWarnings
from followspot.host.clocks import host as host_clock
from followspot.host.clocks.filter import ClockFilter, Exchange
from followspot.host.clocks.host import HostClock
from followspot.operating_system import wall_clock
from followspot.security.request_guard import Asked, Rejected, RequestGuard, envelope
from followspot.worker import clock as worker_clock
from followspot.worker.clock import Clock

MS = 1_000_000
S = 1_000_000_000


def exchange(offset: int, there: int, back: int) -> Exchange:
    """An exchange with a clock that is `offset` ahead; the ways there and back take so many ns."""
    seen = offset + (there - back) // 2
    return Exchange(seen, seen, there + back)


@given(
    offset=st.integers(-(10**15), 10**15),
    delays=st.lists(st.tuples(st.integers(0, 200 * MS), st.integers(0, 200 * MS)), min_size=1, max_size=40),
)
def test_the_offset_is_within_half_the_round_trip_of_the_quickest_exchanges(
    offset: int, delays: list[tuple[int, int]]
) -> None:
    clocks = ClockFilter()
    for there, back in delays:
        clocks.add(exchange(offset, there, back))
    found = clocks.offset()
    assert found is not None
    best = sorted(there + back for there, back in delays[-16:])[:5]
    assert abs(found.captured - offset) <= best[-1] // 2 + 1
    assert found.round_trip <= best[-1]


def test_a_few_slow_answers_do_not_matter() -> None:
    clocks, noise = ClockFilter(), random.Random(7)
    for number in range(40):
        slow = noise.randrange(50 * MS, 300 * MS) if number % 3 == 0 else 0
        clocks.add(exchange(20 * MS, 200_000 + slow, 200_000))
    found = clocks.offset()
    assert found is not None
    assert abs(found.captured - 20 * MS) <= 1


def test_a_clock_that_was_set_gives_the_new_offset_at_once() -> None:
    clocks = ClockFilter()
    for _ in range(30):
        clocks.add(exchange(0, 300_000, 200_000))
    clocks.add(exchange(50 * MS, 300_000, 200_000))
    found = clocks.offset()
    assert found is not None
    assert abs(found.captured - 50 * MS) <= 250_000
    assert clocks.exchanges == 1


@pytest.mark.parametrize(
    ("captured", "steady", "kept"),
    [
        (0.9, 0.9, 2),  # drift, or a thread that woke late
        (-0.9, -0.9, 2),
        (1.7, 0.0, 1),  # the clock was set
        (0.0, 1.7, 1),  # the host was rebooted
        (0.0, -1.7, 1),
    ],
)
def test_exchanges_that_differ_by_over_a_millisecond_drop_the_older_ones(
    captured: float, steady: float, kept: int
) -> None:
    clocks = ClockFilter()
    clocks.add(Exchange(0, 0, 400_000))
    clocks.add(Exchange(round(captured * MS), round(steady * MS), 400_000))
    assert clocks.exchanges == kept


def test_slow_drift_is_followed() -> None:
    clocks = ClockFilter()
    for second in range(1000):
        clocks.add(exchange(second * 50_000, 400_000, 300_000))
    found = clocks.offset()
    assert found is not None
    assert abs(found.captured - 999 * 50_000) <= 16 * 50_000 + 350_000
    assert clocks.exchanges == 16, "50 ppm is no step"


def test_live_capture_times_are_corrected_and_recorded_ones_are_not() -> None:
    clock = Clock(captured=40 * MS)
    now = time.time_ns()
    assert clock.capture_time(now) == now + 40 * MS
    assert clock.capture_time(1_000_000) == 1_000_000, "a recording that begins at 0"


def test_a_clock_far_off_is_warned_about_and_a_good_one_is_not() -> None:
    assert "3.0 ms" not in ClockStatus("pc-left", 3.0, 0.5, 16).warning
    assert "40.0 ms behind that of pc-left" in ClockStatus("pc-left", 40.0, 0.5, 16).warning
    assert "ahead of that of pc-left" in ClockStatus("pc-left", -LIMIT_MS, 0.5, 16).warning
    assert "could not be compared" in ClockStatus("pc-left", 0.0, 0.0, 0).warning
    assert not ClockStatus().warning


def test_a_clock_is_warned_about_each_time_that_it_is_set_wrongly_and_not_more_often() -> None:
    warnings = ClockWarnings()

    def said(offset_ms: float, exchanges: int = 16) -> str:
        return warnings.news(ClockStatus("pc-left", offset_ms, 0.4, exchanges))

    assert "could not be compared" in said(0.0, exchanges=0)
    assert said(0.0, exchanges=0) == said(1.0) == ""
    assert "50.0 ms behind" in said(50.0)
    assert said(50.3) == said(48.0) == ""
    assert "50.0 ms ahead of" in said(-50.0), "it was set again"
    assert said(0.0) == ""
    assert "6.0 ms behind" in said(6.0)
    assert said(4.9) == said(5.1) == "", "it hovers"


def test_a_host_without_peers_adds_its_configured_offset() -> None:
    clock = HostClock(known=25 * MS)
    clock.follow("pc-left")
    assert clock.correction()[:2] == (25 * MS, 0)
    assert clock.news() == clock.correction()
    assert clock.news() is None, "told once"


@pytest.fixture
def walls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The wall clock, ns, which the test sets; the monotonic clock stands still."""
    now = [1_700_000_000 * S]
    read = SimpleNamespace(time_ns=lambda: now[0], monotonic_ns=lambda: 5 * S)
    for module in (wall_clock, worker_clock, host_clock):
        monkeypatch.setattr(module, "time", read)
    return now


@pytest.mark.parametrize("step", [63 * S, -63 * S, 2 * S, -2 * S, 3_600 * S])
def test_capture_times_go_on_at_once_if_the_wall_clock_is_set(walls: list[int], step: int) -> None:
    clock, began = Clock(captured=40 * MS), walls[0]
    walls[0] += step
    assert clock.capture_time(walls[0]) == began + 40 * MS
    assert clock.capture_time(1_000_000) == 1_000_000, "a recording that begins at 0"
    clock.correct(50 * MS, 0, began - 5 * S)
    assert clock.capture_time(walls[0]) == began + 50 * MS, "the host measured it before"


def test_what_came_before_the_wall_clock_was_set_keeps_its_time(walls: list[int]) -> None:
    clock, began = Clock(captured=40 * MS), walls[0]
    came = clock.arrival()
    walls[0] += 2 * S
    assert clock.capture_time(began, came) == began + 40 * MS


def test_a_thread_that_is_held_up_between_two_readings_sets_no_clock(walls: list[int]) -> None:
    clock, began = Clock(), walls[0]
    walls[0] += MS // 2
    assert clock.capture_time(walls[0]) == began + MS // 2


def test_a_run_goes_by_its_reference_clock_as_it_was_and_says_that_it_was_set(
    walls: list[int],
) -> None:
    clock, began = HostClock(known=25 * MS), walls[0]
    before = clock.correction()
    assert clock.step_news() is None
    for step in (63 * S, -20 * S, 0):
        walls[0] = began + step
        assert clock.read().captured == began + 25 * MS
        assert clock.step_news() == step
        assert clock.step_news() is None, "told once"
        assert clock.correction() == before
    assert HostClock().read().captured == walls[0], "of a run that begins now"


def test_hosts_may_only_read_clocks_and_operators_may_ask_all() -> None:
    gate = RequestGuard("pc-right", ["clock", "stop"], open_to_hosts=["clock"])
    clock, stop = (Asked("pc-right", verb, "camera", "pc-left") for verb in ("clock", "stop"))
    assert gate.admit(clock, envelope(clock, {})) == {}
    with pytest.raises(Rejected, match="may not stop"):
        gate.admit(stop, envelope(stop, {"run": "1"}))

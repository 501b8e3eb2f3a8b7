"""Capture times of a live source that leap away from the clock of its host take no watermark along."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.core.worker.live_bench import Bench, Device, Note

from followspot import Context, Source, at
from followspot.messages import Message
from followspot.worker.clock import Arrival

SECOND = 1_000_000_000
NOW = 1_000_000 * SECOND


class Watch(Device):
    """A device whose clock has these readings, s after the first; told: its warnings."""

    def __init__(self, *readings: float) -> None:
        super().__init__()
        self.told: list[str] = []
        self.context = replace(Context(), warn=self.told.append)
        self.readings = readings

    def process(self) -> Source[Note]:
        for n, reading in enumerate(self.readings, 1):
            self.asked.release()
            self.wanted.acquire()
            yield at(NOW + round(reading * SECOND), Note(n))
        self.asked.release()


def times(monkeypatch: pytest.MonkeyPatch, device: Watch, arrivals: list[Arrival]) -> list[float]:
    """Capture times of all messages, s after `NOW`; arrivals: when each comes."""
    bench = Bench(device, "out")
    coming = iter(arrivals)
    monkeypatch.setattr("followspot.worker.clock.Clock.arrival", lambda self: next(coming))
    bench.begin()
    for _ in arrivals:
        device.make(1)
        bench.pull_all()
    bench.runner.stop()
    assert bench.count().delivered + bench.count().in_flight == len(arrivals), "none is refused"
    found: list[Message] = list(bench.queues[0].messages)
    return [(message.header.time - NOW) / SECOND for message in found]


def punctual(*seconds: float) -> list[Arrival]:
    return [Arrival(NOW + round(s * SECOND), 0) for s in seconds]


def test_a_time_that_leaps_is_that_of_arrival_and_the_next_ones_are_as_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    device = Watch(0.0, 1.0, 302.0, 3.0)
    assert times(monkeypatch, device, punctual(0.1, 1.1, 2.1, 3.1)) == [0.0, 1.0, 2.1, 3.0]
    assert device.told == [
        "capture times leap 300 s ahead: those of arrival are taken; look at the clock of the device"
    ]


def test_a_clock_that_was_set_for_good_leaves_the_times_of_arrival(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Watch(0.0, -3600.0, -3599.0)
    assert times(monkeypatch, device, punctual(0.1, 1.1, 2.1)) == [0.0, 1.1, 2.1]
    assert "leap 3601 s back" in device.told[0]


def test_times_of_a_recording_are_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Watch(0.0, 1.0, 400.0)
    assert times(monkeypatch, device, punctual(5000.0, 5001.0, 5002.0)) == [0.0, 1.0, 400.0]
    assert device.told == []


def test_a_device_goes_on_if_the_clock_of_its_host_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Watch(0.0, 1.0, 2.0)
    arrivals = [
        Arrival(NOW + SECOND // 10, 20 * SECOND),
        *(Arrival(NOW + (500 + n) * SECOND, -480 * SECOND, 500 * SECOND) for n in (1, 2)),
    ]
    assert times(monkeypatch, device, arrivals) == [20.0, 21.0, 22.0], "the clock of the run is 20 s ahead"
    assert device.told == []


def test_times_that_go_back_are_told_in_two_lines_however_many_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    device = Watch(5.0, 1.0, 2.0, 3.0, 4.0)
    bench = Bench(device, "out")
    told: list[str] = []
    (output,) = (output for _, output in bench.runner.outputs)
    output.refused = told.append
    coming = iter(punctual(1.0, 1.1, 2.1, 3.1, 4.1))
    monkeypatch.setattr("followspot.worker.clock.Clock.arrival", lambda self: next(coming))
    bench.begin()
    for _ in range(5):
        device.make(1)
        bench.pull_all()
    bench.runner.stop()
    assert bench.count().invalid == 4
    assert told[0] == f"time {NOW + SECOND} ns lies before the watermark {NOW + 5 * SECOND + 1} ns"
    assert told[1:] == ["later times lie before that watermark, too"] * 3

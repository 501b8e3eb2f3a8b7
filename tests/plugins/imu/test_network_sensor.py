"""What all sensors in the network have in common: clocks, losses, silence, limits."""

from __future__ import annotations

import socket
from itertools import count

import numpy as np
import pytest
from tests.plugins.imu.network import AtWork, bundle, osc
from tests.plugins.imu.ximu3_messages import binary

from followspot import Context, InputError, Member
from followspot.sensors.device_clock import LEAST, DeviceClock
from followspot.testing import tiny_room
from followspot_imu.network import sensor
from followspot_imu.network.listener import Datagram
from followspot_imu.network.losses import Losses
from followspot_imu.network.osc import Osc
from followspot_imu.network.sensor import NetworkSensor
from followspot_imu.network.ximu3 import Ximu3

MS = 1_000_000
REST = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def test_capture_times_follow_the_least_delayed_datagrams() -> None:
    clock, rng = DeviceClock(), np.random.default_rng(3)
    delay = rng.exponential(5 * MS, 4000).astype(int)
    device = 10 * MS * np.arange(4000)
    found = np.array(
        [
            clock.capture_time(int(d), int(d) + 70_000 * MS + int(late))
            for d, late in zip(device, delay, strict=True)
        ]
    )
    assert (np.diff(found) > 0).all()
    assert np.abs(found[500:] - device[500:] - 70_000 * MS).max() < MS


def test_a_clock_that_drifts_is_followed() -> None:
    clock = DeviceClock()
    error = [
        (clock.capture_time(k * 10 * MS, round(k * 10 * MS * (1 + 50e-6))) or 0) - k * 10 * MS * (1 + 50e-6)
        for k in range(20_000)
    ]
    assert np.abs(error).max() < 1.1 * MS


def test_a_first_datagram_that_was_slow_costs_no_reading() -> None:
    clock = DeviceClock()
    times = [clock.capture_time(0, 900 * MS), *(clock.capture_time(k * MS, k * MS) for k in range(1, 5))]
    assert times == [900 * MS + LEAST * k for k in range(5)]
    assert clock.capture_time(4 * MS, 5 * MS) is None


def test_a_device_that_starts_anew_is_followed_and_told() -> None:
    clock = DeviceClock()
    assert clock.capture_time(5000 * MS, 10_000 * MS) == 10_000 * MS
    assert clock.capture_time(3 * MS, 10_500 * MS) == 10_500 * MS
    assert clock.restarts == 1


def test_a_device_whose_clock_jumps_ahead_is_followed_and_misses_no_readings() -> None:
    clock = DeviceClock()
    clock.capture_time(0, 10_000 * MS)
    for k, device in enumerate((10**15, 2 * 10**15, 3 * 10**15), 1):
        assert clock.capture_time(device, (10_000 + k) * MS) == (10_000 + k) * MS
        assert (clock.restarts, clock.interval) == (k, 0)


def test_a_gap_that_lasted_is_an_interval_also_if_the_reading_after_it_was_quick() -> None:
    clock = DeviceClock()
    clock.capture_time(0, 10_900 * MS)
    assert clock.capture_time(5000 * MS, 15_000 * MS) is not None
    assert (clock.restarts, clock.interval) == (0, 5000 * MS)


def test_missing_readings_are_counted_by_the_rate_or_by_the_usual_interval() -> None:
    known, unknown = Losses(400.0), Losses(None)
    assert [known.within(round(n * 2.5 * MS * 1.02)) for n in (1, 2, 6)] == [0, 1, 5]
    assert known.within(0) == 0
    assert sum(unknown.within(10 * MS + n % 3) for n in range(40)) == 0
    assert unknown.within(40 * MS) == 3


def test_losses_and_datagrams_that_are_none_are_counted_and_told() -> None:
    with AtWork(Ximu3) as work:
        for k in (*range(30), *range(40, 60)):  # 100 readings a second, as the room says
            work.send(binary("I", 10_000 * k, *REST))
        work.send(binary("I", 10_000 * 45, *REST))
        work.send(b"I,1,2\n", b"\xc9\x0a", b"F,17,flat battery\n" + binary("F", 1), b"i\n", b"\n" * 100)
        work.send(binary("I", 10_000 * 60, 1e9, *REST[1:]), binary("I", 10_000 * 61, float("nan"), *REST[1:]))
    assert len(work.column("time")) == 50
    (sums,) = [line for line in work.told if "first" not in line]
    assert sums.startswith("imu0: ")
    counts = dict(reversed(part.split(" ", 1)) for part in sums[6:].split(", "))
    assert counts["missing readings"] == "10"
    assert counts["readings that came too late or twice"] == "1"
    assert counts["readings out of range"] == "1"
    assert counts["messages that cannot be read"] == "104"
    assert any("flat battery" in line for line in work.told)


def test_only_the_sender_that_was_named_is_heard() -> None:
    with AtWork(Ximu3, sender="127.0.0.9") as work:
        work.send(binary("I", 1, *REST))
    assert not work.sent
    assert work.told == [
        "imu0: first datagrams of other senders: 127.0.0.1",
        "imu0: 1 datagrams of other senders",
    ]


def test_silence_is_told_once_and_so_is_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    arrivals = count(0, 100 * MS)
    whole = [Datagram(b"", next(arrivals), "") for _ in range(40)]
    for k in (5, 39):
        whole[k] = Datagram(binary("I", k, *REST), whole[k].arrival, "127.0.0.1")
    monkeypatch.setattr(sensor, "opened", lambda *_: socket.socket())
    monkeypatch.setattr(sensor, "datagrams", lambda *_: iter(whole))
    told: list[str] = []
    stage = Ximu3(Context("imu", tiny_room(), Member("sensors", "imu0"), warn=told.append), batch=1)
    assert len(list(stage.process())) == 2
    assert told == [
        "imu0: no reading arrives at 127.0.0.1:8000",
        "imu0: readings arrive again at 127.0.0.1:8000",
    ]


def test_a_port_that_is_taken_is_refused_with_a_remedy() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        context = Context("imu", tiny_room(), Member("sensors", "imu0"))
        stage = Ximu3(context, port=other.getsockname()[1])
        with pytest.raises(InputError, match="one that no other sensor uses"):
            next(stage.process())


def played(
    kind: type[NetworkSensor], datagrams: list[Datagram], monkeypatch: pytest.MonkeyPatch
) -> list[str]:
    """What the stage tells of datagrams that arrive at their times."""
    monkeypatch.setattr(sensor, "opened", lambda *_: socket.socket())
    monkeypatch.setattr(sensor, "datagrams", lambda *_: iter(datagrams))
    told: list[str] = []
    stage = kind(Context("imu", tiny_room(), Member("sensors", "imu0"), warn=told.append))
    assert list(stage.process())
    return told


@pytest.mark.parametrize(
    ("turning", "force", "doubts"),
    [
        (0.5, 9.8, []),
        (0.5, 1.0, ["accelerometer reads 1 m/s^2 at the median"]),
        (60.0, 9.8, ["gyroscope reads 60 rad/s"]),
    ],
)
def test_units_that_are_hardly_right_are_told_once(
    turning: float, force: float, doubts: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    values = (turning, 0.0, 0.0, 0.0, 0.0, force, 0.0, 0.0, 0.0)
    whole = [Datagram(osc("/sensors", *values), k * 5 * MS, "127.0.0.1") for k in range(1, 301)]
    told = played(Osc, whole, monkeypatch)
    assert len(told) == len(doubts)
    assert all(doubt in text and "right?" in text for doubt, text in zip(doubts, told, strict=True))
    still = [Datagram(binary("I", 5000 * k, 0, 0, 0, 0, 0, 0.1), k * 5 * MS, "a") for k in range(1, 301)]
    (told_of_device,) = played(Ximu3, still, monkeypatch)
    assert told_of_device.endswith("where a sensor at rest reads 9.8")


def test_readings_without_a_time_that_arrive_together_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    values = (0.1, 0.0, 0.0, 0.0, 0.0, 9.8, 0.0, 0.0, 0.0)
    five = bundle(*[osc("/sensors", *values)] * 5)
    told = played(Osc, [Datagram(five, k * 25 * MS, "127.0.0.1") for k in range(1, 11)], monkeypatch)
    assert "let the sender send its time" in told[0]
    assert told[1] == "imu0: 40 readings without a time that arrived with the one before"
    timed = [
        Datagram(binary("I", 5000 * k, *REST), 25 * MS * (k // 5) + k, "127.0.0.1") for k in range(1, 50)
    ]
    assert not played(Ximu3, timed, monkeypatch)

"""OSC as python-osc writes it, and as nobody should."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder
from tests.plugins.imu.network import AtWork, bundle, osc

from followspot import Context, Member
from followspot.testing import tiny_room
from followspot_imu.network.listener import Datagram
from followspot_imu.network.osc import Osc
from followspot_imu.network.osc_messages import DEEPEST, MOST_MESSAGES, OscError, osc_messages


def test_every_type_of_value_is_read_or_passed_over() -> None:
    build = OscMessageBuilder("/a")
    for value, kind in (
        (1.5, "f"),
        (2.5, "d"),
        (-3, "i"),
        (4, "h"),
        ("five", "s"),
        (b"six666", "b"),
        (True, "T"),
        (7.0, "f"),
    ):
        build.add_arg(value, kind)
    (found,) = osc_messages(build.build().dgram)
    assert found.address == "/a"
    assert [value for value in found.values if value == value] == [1.5, 2.5, -3, 4, 1, 7]


def test_bundles_of_bundles_are_read_in_order() -> None:
    inner = OscBundleBuilder(IMMEDIATELY)
    for k in range(3):
        message = OscMessageBuilder(f"/{k}")
        message.add_arg(float(k))
        inner.add_content(message.build())
    outer = OscBundleBuilder(IMMEDIATELY)
    outer.add_content(inner.build())
    assert [found.address for found in osc_messages(outer.build().dgram)] == ["/0", "/1", "/2"]


@pytest.mark.parametrize(
    ("packet", "why"),
    [
        (b"", "text without an end"),
        (b"/a", "text without an end"),
        (b"/a\0\0", "text without an end"),
        (b"hello\0\0\0,\0\0\0", "does not begin with /"),
        (b"/a\0\0,f\0\0", "beyond the end"),
        (b"/a\0\0,z\0\0", "unknown type"),
        (b"/\xff\0\0,\0\0\0", "not ASCII"),
        (b"/a\0\0," + b"f" * 99 + bytes(1000), "too many"),
        (bundle(*[osc("/a", 1.0)] * (MOST_MESSAGES + 1)), "more than 256 messages"),
        (bundle(osc("/a", 1.0))[:-1], "beyond the end"),
    ],
)
def test_a_packet_beyond_the_rules_is_refused_with_the_reason(packet: bytes, why: str) -> None:
    with pytest.raises(OscError, match=why):
        osc_messages(packet)


def test_bundles_do_not_nest_without_end() -> None:
    packet = osc("/a", 1.0)
    for _ in range(DEEPEST):
        packet = bundle(packet)
    assert len(osc_messages(packet)) == 1
    for _ in range(3000):
        packet = bundle(packet)
    with pytest.raises(OscError, match="within each other"):
        osc_messages(packet)


@given(st.binary(max_size=200), st.integers(0, 60), st.binary(max_size=8))
@settings(max_examples=200, deadline=None)
def test_any_bytes_give_messages_or_a_reason(data: bytes, at: int, patch: bytes) -> None:
    good = bundle(osc("/sensors", *map(float, range(9))), osc("/b", "text", b"blob"))
    for packet in (data, good[:at] + patch + good[at + len(patch) :], bundle(data)):
        try:
            osc_messages(packet)
        except OscError:
            continue


def test_readings_of_one_message_or_of_several_come_with_the_time_they_say() -> None:
    messages = {"/*/gyro": "gx gy gz", "/*/accel": "time - ax ay az"}
    with AtWork(
        Osc, messages=messages, turn_unit="deg/s", force_unit="g", time_unit="ms", at_rest="down"
    ) as work:
        for k in range(7):
            work.send(osc("/phone/gyro", 90.0, 0.0, float(k)))
            work.send(bundle(osc("/phone/accel", 1000.0 + 10 * k, "x", 0.0, 0.0, -1.0)))
    assert len(work.column("time")) == 7
    np.testing.assert_allclose(work.column("turn_rate")[3], [np.pi / 2, 0, np.radians(3)], rtol=1e-6)
    np.testing.assert_allclose(work.column("specific_force")[3], [0, 0, 9.80665], rtol=1e-6)
    assert np.isnan(work.column("field")).all()
    late = np.diff(work.column("time")) - 10_000_000
    assert (late <= 0).all()
    assert not work.told


def test_a_device_may_count_its_time_from_1970_and_none_beyond_all_clocks() -> None:
    told: list[str] = []
    context = Context("imu", tiny_room(), Member("sensors", "imu0"), warn=told.append)
    stage = Osc(context, messages={"/wand": "time gx gy gz ax ay az"})

    def device_time(seconds: float) -> int | None:
        packet = osc("/wand", seconds, 0.0, 0.0, 0.0, 0.0, 0.0, 9.8, kind="d")
        (reading,) = stage.readings(Datagram(packet, 0, "127.0.0.1"))
        return reading.device_time

    assert device_time(1_700_000_000.25) == pytest.approx(1_700_000_000_250_000_000, abs=300)
    assert not told
    assert device_time(1e30) is None
    assert "times out of range" in told[0]


def test_readings_without_a_time_have_that_of_their_arrival() -> None:
    with AtWork(Osc) as work:
        work.send(*(osc("/sensors", *map(float, range(k, k + 9))) for k in range(5)))
    assert len(work.column("time")) == 5
    assert (np.diff(work.column("time")) > 0).all()
    assert work.column("field")[2].tolist() == [8, 9, 10]


def test_what_is_hostile_or_strange_is_counted_and_the_rest_read() -> None:
    good = osc("/sensors", *[0.5] * 9)
    with AtWork(Osc) as work:
        for packet in (b"", b"x" * 60_000, bundle(good)[:-2], b"/sensors\0\0\0\0,z\0\0"):
            work.send(packet, good)
        work.send(osc("/other", 1.0), osc("/sensors", 1.0, 2.0), osc("/sensors", *["text"] * 9))
        work.send(osc("/sensors", *[1e30] * 9), good)
    assert len(work.column("time")) == 5
    (sums,) = [line for line in work.told if "first" not in line]
    for part in (
        "4 datagrams that cannot be read",
        "1 messages to other addresses",
        "1 messages with too few values",
        "1 messages with a value that is no number",
        "1 readings out of range",
    ):
        assert part in sums


@pytest.mark.parametrize(
    ("messages", "told"),
    [
        ({"/a": "gx gy gz ax ay"}, "must have gx gy gz ax ay az"),
        ({"/a": "gx gy gz ax ay az wx"}, '"wx" is no value'),
        ({"a": "gx gy gz ax ay az"}, "begins with /"),
    ],
)
def test_messages_that_make_no_reading_are_refused(messages: dict[str, str], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        Osc(messages=messages)

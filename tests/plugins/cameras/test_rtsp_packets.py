"""Packets of network cameras: RTP, sender reports, parameters, fragments, losses; and their clocks."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from followspot_cameras.rtsp.access_units import AccessUnit, AccessUnits
from followspot_cameras.rtsp.report_times import ReportTimes
from followspot_cameras.rtsp.rtp import EPOCH, RtpPacket, SenderReport, rtp_packet, sender_report
from followspot_cameras.rtsp.sender_clock import SenderClock
from followspot_cameras.rtsp.session_description import NoVideo, video_of

MS, S = 1_000_000, 1_000_000_000
START = b"\0\0\0\1"


def packet(sequence: int, timestamp: int, payload: bytes, marker: bool = False) -> RtpPacket:
    return RtpPacket(96, marker, sequence, timestamp, payload)


def test_a_packet_is_read_without_sources_extension_and_padding() -> None:
    head = struct.pack(">BBHIII", 0x80 | 0x20 | 0x10 | 1, 0x80 | 96, 7, 90, 1, 2)
    extension = struct.pack(">HHI", 0xBEDE, 1, 5)
    found = rtp_packet(head + extension + b"abc" + b"\0\0\3")
    assert found == RtpPacket(96, True, 7, 90, b"abc")


@pytest.mark.parametrize("data", [b"", b"\x80" * 11, b"\x40" + bytes(20), b"\x9f" + bytes(12), b"\xb0" * 13])
def test_what_is_no_packet_is_left_out(data: bytes) -> None:
    assert rtp_packet(data) is None


def test_a_sender_report_is_found_behind_other_reports() -> None:
    clock = 1_700_000_000 * S + 250 * MS
    ntp = ((clock // S + EPOCH) << 32) + (1 << 30)
    before = struct.pack(">BBHI", 0x80, 201, 1, 9)
    report = struct.pack(">BBHIQIII", 0x80, 200, 6, 9, ntp, 4711, 0, 0)
    assert sender_report(before + report) == SenderReport(clock, 4711)
    assert sender_report(before) is None
    assert sender_report(struct.pack(">BBHIQIII", 0x80, 200, 6, 9, 0, 4711, 0, 0)) is None
    assert sender_report(report[:15]) is None


def test_fragments_and_aggregates_become_one_picture() -> None:
    units = AccessUnits("h264")
    aggregate = b"\x18" + b"\0\2\x67a" + b"\0\2\x68b"
    assert units.add(packet(1, 10, aggregate), 5) is None
    assert units.add(packet(2, 10, b"\x7c\x85AB"), 6) is None
    assert units.add(packet(3, 10, b"\x7c\x05CD"), 7) is None
    found = units.add(packet(4, 10, b"\x7c\x45E", marker=True), 8)
    data = START + b"\x67a" + START + b"\x68b" + START + b"\x65ABCDE"
    assert found == AccessUnit(data, 10, False, 5)


def test_fragments_of_h265_become_one_picture() -> None:
    units = AccessUnits("hevc")
    units.add(packet(1, 10, b"\x62\x01\x93AB"), 5)
    found = units.add(packet(2, 10, b"\x62\x01\x53C", marker=True), 6)
    assert found is not None
    assert found.data == START + b"\x26\x01ABC"


def test_a_picture_with_a_missing_packet_is_damaged_and_the_next_is_whole() -> None:
    units = AccessUnits("h264")
    units.add(packet(65_535, 10, b"\x7c\x85AB"), 1)
    lost = units.add(packet(1, 10, b"\x41rest", marker=True), 2)
    whole = units.add(packet(2, 20, b"\x41next", marker=True), 3)
    assert lost is not None
    assert lost.damaged
    assert whole is not None
    assert (whole.damaged, whole.data) == (False, START + b"\x41next")


def test_a_picture_whose_last_packet_is_missing_ends_with_the_next_time() -> None:
    units = AccessUnits("h264")
    assert units.add(packet(1, 10, b"\x41one"), 1) is None
    found = units.add(packet(2, 20, b"\x41two", marker=True), 2)
    assert found is not None
    assert (found.timestamp, found.arrival) == (10, 1)


@pytest.mark.parametrize("begin", [b"\x7c\x85AB", b"\x41\x80slice"])
def test_a_picture_whose_last_packet_is_lost_is_damaged_and_the_next_is_whole(begin: bytes) -> None:
    units = AccessUnits("h264")
    units.add(packet(1, 10, begin), 1)
    lost = units.add(packet(3, 20, b"\x41\x80next"), 2)
    whole = units.add(packet(4, 30, b"\x41\x80more"), 3)
    assert lost is not None
    assert (lost.timestamp, lost.damaged, lost.lost) == (10, True, 1)
    assert whole is not None
    assert (whole.timestamp, whole.damaged, whole.lost) == (20, False, 0)


@pytest.mark.parametrize(
    ("codec", "first", "later"),
    [("h264", b"\x41\x80", b"\x41\x40"), ("hevc", b"\x02\x01\x80", b"\x02\x01\x40")],
)
def test_a_loss_between_pictures_is_one_picture_and_one_within_damages_it(
    codec: str, first: bytes, later: bytes
) -> None:
    for begin, damaged in ((first, False), (later, True)):
        units = AccessUnits(codec)
        before = units.add(packet(1, 10, first + b"one", marker=True), 1)
        found = units.add(packet(3, 30, begin + b"two", marker=True), 2)
        after = units.add(packet(4, 40, first + b"three", marker=True), 3)
        assert before is not None
        assert before.lost == 0
        assert found is not None
        assert (found.damaged, found.lost) == (damaged, 1)
        assert after is not None
        assert (after.damaged, after.lost) == (False, 0)


@pytest.mark.parametrize(("drift", "from_second"), [(-1e-4, 20), (1e-4, 20), (-1e-3, 100), (1e-3, 100)])
def test_a_clock_that_is_off_and_drifts_gives_times_within_five_milliseconds(
    drift: float, from_second: int
) -> None:
    """Drifts of quartz crystals from the beginning, and any other one once it was seen for a while."""
    clock, rng = SenderClock(90_000), np.random.default_rng(2)

    def sender(now: float) -> float:
        return now - 0.25 + drift * now

    for second in range(5, 600, 5):
        there = sender(second)
        stamp = round(there * 90_000) % (1 << 32)
        clock.add(SenderReport(round(there * S), stamp), second * S + int(rng.exponential(1 * MS)))
        now = second + 2.5
        found = clock.capture_time(round(sender(now) * 90_000) % (1 << 32))
        assert found is not None
        if second >= from_second:
            assert abs(found / S - now) < 5e-3
    assert abs(clock.drift + drift) < 2e-5


def test_the_user_is_told_once_how_much_a_clock_drifts() -> None:
    said: list[str] = []
    times = ReportTimes(0, said.append)
    times.begin(90_000, 0)
    for second in range(5, 200, 5):
        times.report(SenderReport(round(second * 1.0003 * S), 0), second * S)
    assert [text for text in said if "drifts" in text] == ["its clock drifts by +300 ppm, which is followed"]


def test_a_clock_that_is_set_is_followed_at_once() -> None:
    clock = SenderClock(90_000)
    clock.add(SenderReport(100 * S, 0), 100 * S)
    clock.add(SenderReport(50 * S, 90_000), 101 * S)
    assert clock.capture_time(90_000) == 101 * S
    assert clock.settings == 1


def test_a_report_that_cannot_be_true_counts_as_none() -> None:
    said: list[str] = []
    times = ReportTimes(0, said.append)
    times.begin(90_000, 0)
    times.report(SenderReport(100 * S, 0), 100 * S)
    unit = AccessUnit(b"", 90_000 * 3600, False, 101 * S)
    assert times.capture_time(unit) == 101 * S
    assert "wrong reports" in said[-1]


def test_pictures_of_a_session_without_reports_count_as_late_as_those_of_the_one_before() -> None:
    said: list[str] = []
    times = ReportTimes(S, said.append)
    times.begin(90_000, 0)
    times.report(SenderReport(100 * S, 0), 100 * S)
    for second in range(1, 50):
        assert times.capture_time(AccessUnit(b"", second * 90_000, False, (100 + second) * S + 40 * MS))
    times.begin(90_000, 200 * S)  # the server was started again: its time stamps have another origin
    for second in range(200, 210):
        found = times.capture_time(AccessUnit(b"", second, False, second * S + 40 * MS))
        assert found == second * S
    assert said == []


def test_capture_times_rise() -> None:
    times = ReportTimes(0, lambda text: None)
    times.begin(90_000, 0)
    times.report(SenderReport(100 * S, 90_000), 100 * S)
    assert times.capture_time(AccessUnit(b"", 90_000, False, 100 * S)) == 100 * S
    assert times.capture_time(AccessUnit(b"", 90_000, False, 100 * S)) is None


SDP = """v=0
m=audio 0 RTP/AVP 0
a=rtpmap:0 PCMU/8000
m=video 0 RTP/AVP 96
a=rtpmap:96 H264/90000
a=fmtp:96 packetization-mode=1; sprop-parameter-sets=Z0I=,aM4=
a=control:trackID=1
"""


def test_the_video_of_a_description_is_found_behind_its_sound() -> None:
    video = video_of(SDP, "rtsp://a/cam/")
    assert (video.codec, video.payload_type, video.rate) == ("h264", 96, 90_000)
    assert video.control == "rtsp://a/cam/trackID=1"
    assert video.parameters == START + b"\x67\x42" + START + b"\x68\xce"


def test_a_video_that_cannot_be_read_is_named() -> None:
    with pytest.raises(NoVideo, match=r"it sends PCMU, JPEG; H\.264 and H\.265 can be read"):
        video_of(SDP.replace("H264", "JPEG"), "rtsp://a/cam")

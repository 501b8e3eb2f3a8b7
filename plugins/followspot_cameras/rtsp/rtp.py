"""RTP packets and RTCP sender reports (RFC 3550, sections 5.1 and 6.4.1)."""

from __future__ import annotations

import struct
from typing import NamedTuple

EPOCH = 2_208_988_800
"""1970 in seconds of NTP, which begin in 1900."""
SENDER_REPORT = 200


class RtpPacket(NamedTuple):
    """marker: True for the last packet of a picture; payload: without header extensions and padding."""

    payload_type: int
    marker: bool
    sequence: int
    timestamp: int
    payload: bytes


class SenderReport(NamedTuple):
    """A moment by the sender's clock, ns since 1970, and the same moment in units of RTP time stamps."""

    clock: int
    timestamp: int


def rtp_packet(data: bytes) -> RtpPacket | None:
    """The packet in some bytes; None if they are none."""
    if len(data) < 12 or data[0] >> 6 != 2:
        return None
    _, second, sequence, timestamp, _ = struct.unpack_from(">BBHII", data)
    start = 12 + 4 * (data[0] & 0x0F)
    if data[0] & 0x10:  # a header extension
        if len(data) < start + 4:
            return None
        start += 4 + 4 * struct.unpack_from(">H", data, start + 2)[0]
    end = len(data) - (data[-1] if data[0] & 0x20 else 0)
    if start > end:
        return None
    return RtpPacket(second & 0x7F, bool(second & 0x80), sequence, timestamp, data[start:end])


def sender_report(data: bytes) -> SenderReport | None:
    """The first sender report in an RTCP packet, which may be compound; None if it has none."""
    at = 0
    while at + 8 <= len(data) and data[at] >> 6 == 2:
        size = 4 * (struct.unpack_from(">H", data, at + 2)[0] + 1)
        if data[at + 1] == SENDER_REPORT and at + 20 <= len(data):
            seconds, fraction, timestamp = struct.unpack_from(">III", data, at + 8)
            if seconds == 0:  # the sender has no clock
                return None
            return SenderReport((seconds - EPOCH) * 10**9 + (fraction * 10**9 >> 32), timestamp)
        at += size
    return None

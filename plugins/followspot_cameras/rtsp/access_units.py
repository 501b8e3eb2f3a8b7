"""Pictures of H.264 (RFC 6184) and H.265 (RFC 7798) from the payloads of RTP packets, as Annex B streams."""

from __future__ import annotations

from typing import Literal, NamedTuple

from followspot_cameras.rtsp.rtp import RtpPacket
from followspot_cameras.rtsp.session_description import START

MOST_BYTES = 32 << 20
"""Of one picture."""


class AccessUnit(NamedTuple):
    """One picture.

    damaged: packets of it are missing, perhaps all that have data; arrival: of its first packet, ns;
    after_lost: all packets of a picture before it are missing, or of several.
    """

    data: bytes
    timestamp: int
    damaged: bool
    arrival: int
    after_lost: bool = False

    @property
    def lost(self) -> int:
        """Pictures that its missing packets cost."""
        return self.damaged + self.after_lost


class AccessUnits:
    """Collects packets into pictures. codec: "h264" or "hevc"."""

    def __init__(self, codec: str) -> None:
        self._codec = codec
        self._units: list[bytes] = []
        self._fragment: bytearray | None = None
        self._timestamp, self._arrival = 0, 0
        self._sequence: int | None = None
        self._damaged = False
        self._loss: Literal["", "before", "between"] = ""
        """Whether packets are missing right before its first: some of them may be its own. "between": the
        picture before has all of its packets."""

    def add(self, packet: RtpPacket, arrival: int) -> AccessUnit | None:
        """Take a packet; the picture that it completes, or that it shows to be complete."""
        skipped = self._sequence is not None and packet.sequence != (self._sequence + 1) & 0xFFFF
        self._sequence = packet.sequence
        begun = bool(self._units) or self._fragment is not None
        before = None
        if begun and packet.timestamp != self._timestamp:
            self._damaged |= skipped
            before = self._taken()
        if before is not None or not begun:
            self._timestamp, self._arrival = packet.timestamp, arrival
            if skipped:
                self._loss = "between" if before is None else "before"
        elif skipped:
            self._damaged, self._fragment = True, None
        (self._add_h264 if self._codec == "h264" else self._add_hevc)(packet.payload)
        if sum(map(len, self._units)) + len(self._fragment or b"") > MOST_BYTES:
            self._units, self._fragment, self._damaged = [], None, True
        if before is None and packet.marker and self._units:
            return self._taken()
        return before

    def _taken(self) -> AccessUnit:
        data = b"".join(START + unit for unit in self._units)
        whole = self._fragment is None and not self._damaged and (not self._loss or self._has_first_slice())
        unit = AccessUnit(data, self._timestamp, not whole, self._arrival, whole and self._loss == "between")
        self._units, self._fragment, self._damaged, self._loss = [], None, False, ""
        return unit

    def _has_first_slice(self) -> bool:
        """Whether its first slice begins the picture: first_mb_in_slice, first_slice_segment_in_pic_flag."""
        head, slices = (1, range(1, 6)) if self._codec == "h264" else (2, range(32))
        kinds = (unit[0] & 0x1F if self._codec == "h264" else unit[0] >> 1 & 0x3F for unit in self._units)
        first = next((u for u, kind in zip(self._units, kinds, strict=True) if kind in slices), b"")
        return len(first) > head and bool(first[head] & 0x80)

    def _add_h264(self, payload: bytes) -> None:
        kind = payload[0] & 0x1F if payload else 0
        if 1 <= kind <= 23:
            self._units.append(payload)
        elif kind == 24:  # STAP-A
            self._add_aggregated(payload[1:])
        elif kind == 28 and len(payload) > 2:  # FU-A
            head = bytes([payload[0] & 0xE0 | payload[1] & 0x1F])
            self._add_fragment(payload[1], head, payload[2:])

    def _add_hevc(self, payload: bytes) -> None:
        kind = payload[0] >> 1 & 0x3F if len(payload) > 2 else 63
        if kind < 48:
            self._units.append(payload)
        elif kind == 48:  # aggregation packet
            self._add_aggregated(payload[2:])
        elif kind == 49:  # fragmentation unit
            head = bytes([payload[0] & 0x81 | (payload[2] & 0x3F) << 1, payload[1]])
            self._add_fragment(payload[2], head, payload[3:])

    def _add_aggregated(self, rest: bytes) -> None:
        while len(rest) > 2:
            size = int.from_bytes(rest[:2], "big")
            if size == 0 or size > len(rest) - 2:
                self._damaged = True
                return
            self._units.append(rest[2 : 2 + size])
            rest = rest[2 + size :]

    def _add_fragment(self, marks: int, head: bytes, rest: bytes) -> None:
        if marks & 0x80:
            self._fragment = bytearray(head)
        if self._fragment is None:
            self._damaged = True
            return
        self._fragment += rest
        if marks & 0x40:
            self._units.append(bytes(self._fragment))
            self._fragment = None

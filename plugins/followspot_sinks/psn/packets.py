"""PosiStageNet 2 packets: chunks of a 16-bit id, a 15-bit length, a flag for sub-chunks, and data."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from followspot.messages import Array
from followspot_sinks.slots.slots import Slots

DATA_PACKET, INFO_PACKET = 0x6755, 0x6756
HEADER = 0x0000
DATA_TRACKERS = 0x0001
POSITION, SPEED, ORIENTATION, STATUS, TIMESTAMP = 0x0000, 0x0001, 0x0002, 0x0003, 0x0006
SYSTEM_NAME, INFO_TRACKERS = 0x0001, 0x0002
TRACKER_NAME = 0x0000
VERSION = (2, 2)
MOST_BYTES = 1400
"""Largest size of the trackers in one packet, which fits into an Ethernet frame with its headers."""


def data_packets(slots: Slots, axes: Array, time: int, frame: int) -> list[bytes]:
    """The positions of one frame, in as many packets as they need.

    axes: (3, 3), PSN's x, y, z from the room's; time: capture time, ns; frame: 0 to 255, repeating.
    """
    rotation = np.linalg.det(axes) * slots.rotation @ axes.T  # a mirror reverses the sense of a rotation
    columns = (slots.position @ axes.T, slots.velocity @ axes.T, rotation, slots.known)
    stamp = _chunk(TIMESTAMP, struct.pack("<Q", max(0, time) // 1000))
    trackers = [
        _chunk(
            row + 1,
            _chunk(POSITION, struct.pack("<3f", *position))
            + _chunk(SPEED, struct.pack("<3f", *speed))
            + _chunk(ORIENTATION, struct.pack("<3f", *turned))
            + _chunk(STATUS, struct.pack("<f", known))
            + stamp,
            parent=True,
        )
        for row, (position, speed, turned, known) in enumerate(
            zip(*(column.tolist() for column in columns), strict=True)
        )
    ]
    return _packets(DATA_PACKET, b"", DATA_TRACKERS, trackers, time, frame)


def info_packets(system: str, names: Sequence[str], time: int, frame: int) -> list[bytes]:
    """Packets with the names of the trackers; to be sent about once a second."""
    trackers = [
        _chunk(number, _chunk(TRACKER_NAME, name.encode()[:255]), parent=True)
        for number, name in enumerate(names, 1)
        if name
    ]
    return _packets(
        INFO_PACKET, _chunk(SYSTEM_NAME, system.encode()[:255]), INFO_TRACKERS, trackers, time, frame
    )


def _packets(
    kind: int, common: bytes, list_id: int, trackers: Sequence[bytes], time: int, frame: int
) -> list[bytes]:
    parts = list(_parts(trackers))
    header = _chunk(HEADER, struct.pack("<QBBBB", max(0, time) // 1000, *VERSION, frame % 256, len(parts)))
    return [_chunk(kind, header + common + _chunk(list_id, part, parent=True), parent=True) for part in parts]


def _parts(trackers: Iterable[bytes]) -> Iterator[bytes]:
    """The trackers, as many together as fit into a packet; one empty part if there are none."""
    part = b""
    for tracker in trackers:
        if len(part) + len(tracker) > MOST_BYTES:
            yield part
            part = b""
        part += tracker
    yield part


def _chunk(number: int, data: bytes, parent: bool = False) -> bytes:
    return struct.pack("<I", number | len(data) << 16 | parent << 31) + data

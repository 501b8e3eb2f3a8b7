"""Messages to record, and recordings of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from followspot import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.testing import tiny_room
from followspot.tracking import Frame, Tracks
from followspot_recording.sink import RecordingSink

ROOM = tiny_room()
SPACING = 16_666_667


def frame(number: int) -> Frame:
    pixels = np.random.default_rng(number).integers(0, 256, (20, 24, 3), "u1")
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number * SPACING, 99))


def tracks(number: int) -> Tracks:
    xyz = np.array([[0.1 * number, 0.0, 1.0], [np.nan, 0.0, 0.0]])
    told = Tracks(np.array([0, 1], "i4"), np.array([1, 2], "u1"), xyz, xyz, np.full((2, 3), 0.01))
    return stamped(seal(told), Header("camera/cam0", number, number * SPACING, 7))


def record(path: Path, count: int = 40, **params: object) -> Path:
    """Two ports, `count` messages each, through the sinks."""
    about = {"metadata": {"graph": "toy"}, "attachments": {"graph/toy.yaml": "graph: toy\n"}}
    first = RecordingSink(Context("a", ROOM), path=path, port="camera/cam0.out", **about, **params)
    second = RecordingSink(Context("b", ROOM), path=path, port="track.tracks", **params)
    for sink in (first, second):
        sink.setup()
    for number in range(count):
        first.process(frame(number))
        second.process(tracks(number))
    first.close()
    second.close()
    return path

"""Taps show what belongs together, and never wait."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot.context import Context
from followspot.inertial import Inertial
from followspot.messages import Header, Message, stamped
from followspot.taps import sender
from followspot.taps.framing import Record
from followspot.taps.receivers import LocalReceiver
from followspot.tracking import Frame, Tracks
from followspot.wire import unpack
from followspot_dashboard.gate import SOCKET, Gate, make_gate
from followspot_dashboard.pace import Pace
from followspot_dashboard.picture import Picture, picture_of
from followspot_dashboard.tap import Tap

MS = 1_000_000


def at(time_ms: float, message: Message) -> Message:
    return stamped(message, Header("camera/cam0", 0, int(time_ms * MS)))


def frame(value: int = 0, size: tuple[int, int] = (48, 64), channels: int = 3) -> Frame:
    return Frame("cam0", np.full((*size, channels), value, np.uint8))


class Listener:
    """The page's end of the connections."""

    def __init__(self, folder: Path) -> None:
        self.records: list[Record] = []
        self.receiver = LocalReceiver(folder / SOCKET, self.records.extend)

    def heard(self, *taps: Tap) -> list[tuple[str, bytes]]:
        """What has come when these taps have left."""
        for tap in taps:
            tap.close()
        self.receiver.close(60.0)
        return [(port, packed) for port, _, packed in self.records]


@pytest.fixture
def listener(tmp_path: Path) -> Iterator[Listener]:
    found = Listener(tmp_path)
    yield found
    found.receiver.close()


@pytest.fixture
def gate(tmp_path: Path) -> Iterator[Gate]:
    made = make_gate(tmp_path)
    made.watched = True
    yield made
    made.close()


def tap(folder: Path, port: str = "camera/cam0.out", **params: float) -> Tap:
    made = Tap(Context(name="tap"), folder=str(folder), socket=str(folder / SOCKET), port=port, **params)
    made.setup()
    return made


def test_a_picture_arrives_small_and_with_its_moment(tmp_path: Path, gate: Gate, listener: Listener) -> None:
    made = tap(tmp_path)
    made.process(at(5, frame(90, (480, 640))))
    [(port, packed)] = listener.heard(made)
    picture = unpack(packed, Picture)
    assert isinstance(picture, Picture)
    assert port == "camera/cam0.out"
    assert (picture.camera, picture.width, picture.height) == ("cam0", 640, 480)
    assert picture.header.time == 5 * MS
    pixels = cv2.imdecode(picture.jpeg, cv2.IMREAD_UNCHANGED)
    assert pixels is not None
    assert pixels.shape == (240, 320, 3)


def test_nothing_is_compressed_that_no_page_shows(tmp_path: Path, gate: Gate, listener: Listener) -> None:
    gate.watched = False
    made = tap(tmp_path)
    made.process(at(5, frame()))
    assert listener.heard(made) == []


@pytest.mark.parametrize(("watched_only", "sent"), [(True, 0), (False, 1)])
def test_readings_are_sent_only_where_a_page_shows_them_and_tracks_always(
    tmp_path: Path, gate: Gate, listener: Listener, *, watched_only: bool, sent: int
) -> None:
    gate.watched = False
    made = tap(tmp_path, watched_only=watched_only)
    made.process(at(5, Tracks.empty()))
    assert len(listener.heard(made)) == sent


def test_no_reading_is_left_out_between_two_previews(tmp_path: Path, gate: Gate, listener: Listener) -> None:
    made = tap(tmp_path, "imu/wrist.out", message_rate=0.001)
    for number in range(5):
        if number == 4:
            made.next_at = 0  # the next preview is due
        rows = np.full((2, 3), float(number))
        times = np.array([10 * number - 5, 10 * number], "i8") * MS
        made.process(at(10 * number, Inertial("wrist", times, rows, rows, rows)))
    first, last = (unpack(packed, Inertial) for _, packed in listener.heard(made))
    assert isinstance(first, Inertial)
    assert isinstance(last, Inertial)
    assert first.time.tolist() == [-5 * MS, 0]
    assert last.time.tolist() == [number * 5 * MS for number in range(1, 9)]
    assert last.turn_rate[:, 0].tolist() == [1, 1, 2, 2, 3, 3, 4, 4]
    assert (last.sensor, last.header.time) == ("wrist", 40 * MS)


def test_readings_that_no_page_waits_for_are_forgotten(
    tmp_path: Path, gate: Gate, listener: Listener
) -> None:
    made = tap(tmp_path, "imu/wrist.out", message_rate=60.0, watched_only=True)
    rows = np.zeros((1, 3))
    for number, watched in enumerate((False, True)):
        gate.watched = watched
        made.next_at = 0
        made.process(at(number, Inertial("wrist", np.array([number], "i8"), rows, rows, rows)))
    [(_, packed)] = listener.heard(made)
    only = unpack(packed, Inertial)
    assert isinstance(only, Inertial)
    assert only.time.tolist() == [1]


def test_taps_of_one_graph_show_the_same_moments(tmp_path: Path, gate: Gate, listener: Listener) -> None:
    source = tap(tmp_path, sets_times=True)
    second = tap(tmp_path, "camera/cam1.out")
    for number in range(200):
        source.process(at(10 * number, frame()))
        second.process(at(10 * number + 3, frame()))  # its shutter opens 3 ms later
    shown: dict[str, list[int]] = {"camera/cam0.out": [], "camera/cam1.out": []}
    for port, packed in listener.heard(source, second):
        picture = unpack(packed, Picture)
        assert isinstance(picture, Picture)
        shown[port].append(picture.header.time // (10 * MS))
    assert len(shown["camera/cam0.out"]) < 200
    assert shown["camera/cam0.out"] == shown["camera/cam1.out"]


def test_a_recording_that_begins_anew_is_shown_again(tmp_path: Path, gate: Gate, listener: Listener) -> None:
    source = tap(tmp_path, sets_times=True)
    gate.choose(80_000 * MS, next_at=0)
    gate.choose(90_000 * MS, next_at=0)
    source.process(at(10, frame()))
    source.process(at(20, frame()))
    assert len(listener.heard(source)) == 1


def test_cameras_slower_than_the_page_are_all_shown(
    tmp_path: Path, gate: Gate, listener: Listener, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [time.monotonic_ns()]
    monkeypatch.setattr(time, "monotonic_ns", lambda: now[0])
    taps = [tap(tmp_path, f"camera/cam{i}.out", sets_times=True, picture_rate=60.0) for i in range(3)]
    for number in range(1, 9):
        now[0] += 20 * MS  # longer than from one picture of the page to the next
        for one in taps:
            one.process(at(100 * number, frame()))
    shown = [port for port, _ in listener.heard(*taps)]
    assert all(shown.count(f"camera/cam{i}.out") >= 6 for i in range(3))  # the first ones set the pace


def test_tracks_are_shown_between_pictures_too(tmp_path: Path, gate: Gate, listener: Listener) -> None:
    tracks = tap(tmp_path, "track.tracks", message_rate=0.001)  # whatever pauses the machine makes
    gate.choose(10**15, next_at=2**62)  # no moment comes
    tracks.process(at(1, Tracks.empty()))
    tracks.process(at(2, Tracks.empty()))  # too soon after the first
    [(_, packed)] = listener.heard(tracks)
    assert isinstance(unpack(packed, Tracks), Tracks)


def test_a_page_that_does_not_listen_costs_previews_and_nothing_else(
    tmp_path: Path, gate: Gate, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sender, "MAX_WAITING", 1 << 16)
    monkeypatch.setattr(sender, "_CLOSING", 0.0)
    with socket.socket(socket.AF_UNIX) as busy:  # never reads
        busy.bind(str(tmp_path / SOCKET))
        busy.listen()
        watched = tap(tmp_path)
        for number in range(2000):
            gate.choose(number * MS, next_at=0)
            watched.process(at(number, frame()))
        assert watched.number == 2000
        assert watched.sender is not None
        assert watched.sender._bytes <= 1 << 16
        watched.close()


def test_a_tap_says_that_its_page_has_gone(tmp_path: Path) -> None:
    lonely = Tap(Context(), folder=str(tmp_path / "gone"), socket=str(tmp_path / "gone" / SOCKET))
    lonely.setup()
    with pytest.raises(EOFError):
        lonely.process(at(0, frame()))
    lonely.close()


@pytest.mark.parametrize(("size", "channels"), [((0, 10), 3), ((10, 10), 2), ((10, 0), 1)])
def test_a_frame_that_is_no_picture_has_no_preview(size: tuple[int, int], channels: int) -> None:
    assert picture_of(frame(0, size, channels), 320) is None


def test_the_next_moment_is_as_far_ahead_as_the_graph_comes_until_it_is_due() -> None:
    pace = Pace()
    for number in range(1, 7):
        pace.add(number * 10 * MS)
    assert pace.ahead(now=100 * MS, period=50 * MS) == 25 * MS  # 6 frames in 100 ms: 3 in 50, less a half
    pace.add(70 * MS)
    assert pace.ahead(now=600 * MS, period=50 * MS) == 5 * MS  # slower than pictures are shown: each frame

"""Taps send to a receiver in another process: no run waits for it, and it counts what is missing."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from followspot import Context
from followspot.messages import Header, Message, stamped
from followspot.taps import sender as tap_sender
from followspot.taps.framing import HEAD, framed_record, framed_records
from followspot.taps.port_tap import PortTap
from followspot.tracking import Frame
from followspot.wire import unpack

PIXELS = np.arange(48 * 64 * 3, dtype="u1").reshape(48, 64, 3)


@pytest.fixture
def door(tmp_path: Path) -> Iterator[socket.socket]:
    """A recorder that has not begun to read."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "recorder"))
        listening.listen()
        listening.settimeout(20)
        yield listening


def frame(number: int) -> Message:
    return stamped(Frame("cam0", PIXELS), Header("camera/cam0", number, number))


def tap(folder: Path, port: str) -> PortTap:
    made = PortTap(socket=folder / "recorder", port=port)
    made.setup()
    return made


def test_every_message_arrives_with_its_number(door: socket.socket, tmp_path: Path) -> None:
    taps = [tap(tmp_path, "camera/cam0.out"), tap(tmp_path, "camera/cam1.out")]
    for number in range(5):
        for each in taps:
            each.process(frame(number))
    sender, _ = door.accept()
    for each in taps:
        each.close()
    found = list(framed_records(sender))
    assert [(port, number) for port, number, _ in found] == [
        (each.port, number) for number in range(5) for each in taps
    ]
    last = unpack(found[-1][2], Frame)
    assert isinstance(last, Frame)
    assert np.array_equal(last.pixels, PIXELS)
    sender.close()


def test_a_recorder_that_does_not_read_holds_up_no_worker_and_takes_bounded_memory(
    door: socket.socket, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tap_sender, "MAX_WAITING", 20 * PIXELS.nbytes)
    made = tap(tmp_path, "camera/cam0.out")
    for number in range(400):
        made.process(frame(number))
    assert made.sender is not None
    assert made.sender._bytes <= 20 * PIXELS.nbytes
    sender, _ = door.accept()
    numbers = []
    closing = Thread(target=made.close)
    for _, number, _ in framed_records(sender):
        numbers.append(number)
        if closing.ident is None and made.sender._bytes < 10 * PIXELS.nbytes:  # there is room again
            made.process(frame(400))
            closing.start()
    closing.join()
    assert numbers == sorted(set(numbers))
    assert 10 < len(numbers) < 401
    assert numbers[-1] == 400  # the gap before it tells how many are missing
    sender.close()


def test_a_recorder_that_has_ended_is_told_nothing_more(door: socket.socket, tmp_path: Path) -> None:
    made = tap(tmp_path, "camera/cam0.out")
    door.accept()[0].close()
    door.close()

    def send_until_it_is_noticed() -> None:
        for number in range(10_000):
            made.process(frame(number))

    with pytest.raises(EOFError):
        send_until_it_is_noticed()
    made.close()
    later = tap(tmp_path, "camera/cam0.out")  # a worker that is started again looks for it in vain
    with pytest.raises(EOFError):
        later.process(frame(0))
    later.close()


class Listeners:
    """Recorders on another host, which come and go."""

    def __init__(self) -> None:
        self.wanted = False
        self.packets: list[bytes] = []

    def send(self, packet: bytes) -> None:
        self.packets.append(packet)

    def close(self) -> None:
        self.wanted = False


def test_a_tap_on_another_host_sends_while_it_is_recorded_there() -> None:
    post = Listeners()
    made = PortTap(Context(post=post), port="camera/cam0.out")
    made.setup()
    made.process(frame(0))
    post.wanted = True
    for number in (1, 2):
        made.process(frame(number))
    post.wanted = False
    with pytest.raises(EOFError):
        made.process(frame(3))
    made.close()
    found = [framed_record(packet) for packet in post.packets]
    assert [record[:2] for record in found if record] == [("camera/cam0.out", 0), ("camera/cam0.out", 1)]
    message = unpack(found[0][2], Frame) if found[0] else None
    assert isinstance(message, Frame)
    assert message.header.seq == 1
    for junk in (b"", b"x" * 20, post.packets[0][:-1], HEAD.pack(0, 0, 9)):
        assert framed_record(junk) is None


def test_a_parcel_that_is_cut_off_is_left_out_and_one_that_cannot_be_is_refused() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(HEAD.pack(4, 0, 1) + b"a" + b"1234" + HEAD.pack(100, 1, 1) + b"a" + b"12")
        theirs.shutdown(socket.SHUT_WR)
        assert list(framed_records(ours)) == [("a", 0, b"1234")]
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(HEAD.pack((1 << 32) - 1, 0, 1))
        with pytest.raises(ValueError, match="bytes"):
            list(framed_records(ours))

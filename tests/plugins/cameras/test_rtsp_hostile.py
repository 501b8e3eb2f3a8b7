"""Servers that send what no camera would: the stage calls them gone, within its time, and takes no harm."""

from __future__ import annotations

import random
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.plugins.cameras.recordings import context

pytest.importorskip("av", reason="av is not installed")
from tests.plugins.cameras.rtsp_server import encoded

from followspot_cameras.rtsp import connection, decoder
from followspot_cameras.rtsp.access_units import AccessUnit, AccessUnits
from followspot_cameras.rtsp.rtp import RtpPacket, rtp_packet, sender_report
from followspot_cameras.rtsp.session_description import START, NoVideo, video_of
from followspot_cameras.rtsp.stage import Rtsp

Answer = bytes | Callable[[socket.socket], None]
SDP = "v=0\r\nm=video 0 RTP/AVP 96\r\na=rtpmap:96 H264/90000\r\na=control:track1\r\n"
LONG = "9" * 5000
"""More digits than Python makes a number of."""


def answer(number: int, body: str = "", more: str = "") -> bytes:
    head = f"RTSP/1.0 200 OK\r\nCSeq: {number}\r\nSession: 7\r\n{more}Content-Length: {len(body)}\r\n\r\n"
    return (head + body).encode()


def packet(channel: int, data: bytes) -> bytes:
    return struct.pack(">BBH", 0x24, channel, len(data)) + data


@contextmanager
def server(*answers: Answer) -> Iterator[int]:
    """Gives one answer to each request, then ends; its port."""
    over = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def work() -> None:
            try:
                client, _ = listening.accept()
                with client:
                    for one in answers:
                        client.recv(4096)
                        if callable(one):
                            while not over.is_set():
                                one(client)
                        else:
                            client.sendall(one)
            except OSError:
                pass  # the client has left

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        try:
            yield listening.getsockname()[1]
        finally:
            over.set()
            thread.join(10)


def said_of(port: int, **params: Any) -> str:
    """Why the stage connects again."""
    said: list[str] = []

    def warn(text: str) -> None:
        said.append(text)
        if "connecting again" in text:
            source.close()

    where = {"url": f"rtsp://u:p@127.0.0.1:{port}/c", "read_timeout": 0.3, "wait_for_report": 0}
    source = Rtsp(context("color", (64, 48), warn=warn), **where, **params)
    assert list(source.process()) == []
    return said[-1]


@pytest.mark.parametrize(
    "answers",
    [
        [f"RTSP/1.0 {LONG} OK\r\nCSeq: 1\r\n\r\n".encode()],
        [f"RTSP/1.0 200 OK\r\nCSeq: 1\r\nContent-Length: {LONG}\r\n\r\n".encode()],
        [b"RTSP/1.0 200 OK\r\nCSeq: 1\r\nContent-Length: -5\r\n\r\n"],
        [b"RTSP\r\n\r\n"],
        [b"\xff" * 200_000],
    ],
)
def test_an_answer_that_is_none_ends_the_connection(answers: list[bytes]) -> None:
    with server(*answers) as port:
        assert "the server's answer cannot be read; connecting again" in said_of(port)


@pytest.mark.parametrize(
    ("description", "more"),
    [
        (SDP.replace("90000", "0"), ""),
        (SDP.replace("90000", LONG), ""),
        (SDP.replace("track1", "rtsp://[::1/x"), ""),
        (SDP.replace("track1", "x"), "Content-Base: rtsp://[bad?\r\n"),
        (SDP + "a=fmtp:96 sprop-parameter-sets=Z0I\u20ac=,!!!,=\r\n", ""),
    ],
)
def test_a_description_with_impossible_values_ends_the_connection(description: str, more: str) -> None:
    with server(answer(1, description, more).replace(b"\xe2\x82\xac", b"\xac\xac\xac")) as port:
        assert "connecting again" in said_of(port)


@pytest.mark.parametrize("ports", ["99999-99999", f"{LONG}-1", "0-0", "-"])
def test_ports_that_are_none_are_left_out(ports: str) -> None:
    more = f"Transport: RTP/AVP;server_port={ports}\r\n"
    with server(answer(1, SDP), answer(2, more=more), answer(3)) as port:
        assert "connecting again" in said_of(port, transport="udp")


def drip(client: socket.socket) -> None:
    client.sendall(b"R")
    time.sleep(0.05)


def flood(client: socket.socket) -> None:
    client.sendall(packet(0, bytes(60_000)) * 10)


@pytest.mark.parametrize("begin", [[], [answer(1, SDP), answer(2)]])
@pytest.mark.parametrize("work", [drip, flood])
def test_a_server_that_never_comes_to_its_answer_is_given_up(
    monkeypatch: pytest.MonkeyPatch, work: Callable[[socket.socket], None], begin: list[bytes]
) -> None:
    kept: list[int] = []

    class Counting(connection.RtspConnection):
        def close(self) -> None:
            kept.append(sum(len(one.data) for one in self._waiting))
            super().close()

    monkeypatch.setattr("followspot_cameras.rtsp.stage.RtspConnection", Counting)
    with server(*begin, work) as port:
        assert "the server does not answer" in said_of(port)
    assert kept[0] < connection.MOST_WAITING + 65_536


def test_pictures_and_reports_of_random_bytes_give_no_frame() -> None:
    rng = random.Random(5)

    def send(client: socket.socket) -> None:
        for number in range(200):
            head = struct.pack(">BBHII", 0x80, rng.choice((96, 224)), number, number * 3000, 7)
            client.sendall(packet(0, head + rng.randbytes(rng.randrange(200))))
            report = struct.pack(">BBHI", 0x80, 200, 6, 7) + rng.randbytes(rng.randrange(30))
            client.sendall(packet(1, report if number % 2 else rng.randbytes(40)))
        client.sendall(answer(3))
        client.shutdown(socket.SHUT_RDWR)

    with server(answer(1, SDP), answer(2), send) as port:
        assert "connecting again" in said_of(port)


@pytest.mark.parametrize(("most", "come"), [(64 * 48, 10), (64 * 48 - 1, 0)])
def test_a_picture_that_claims_too_many_pixels_is_not_decoded(
    monkeypatch: pytest.MonkeyPatch, most: int, come: int
) -> None:
    monkeypatch.setattr(decoder, "MOST_PIXELS", most)
    made = decoder.Decoder(video_of(SDP, ""))
    units = [AccessUnit(b"".join(START + unit for unit in one), 0, False, 0) for one in encoded()]
    assert len([image for unit in units for _, image in made.decode(unit)]) == come


@given(st.binary(max_size=200))
def test_any_bytes_are_a_packet_or_none(data: bytes) -> None:
    found = rtp_packet(data)
    assert found is None or len(found.payload) <= len(data)
    sender_report(data)


@given(st.sampled_from(["h264", "hevc"]), st.lists(st.tuples(st.integers(0, 9), st.binary(max_size=12))))
def test_any_payloads_are_pictures_no_larger_than_they(codec: str, parts: list[tuple[int, bytes]]) -> None:
    units, size = AccessUnits(codec), 0
    for number, (time_stamp, payload) in enumerate(parts):
        size += len(payload)
        found = units.add(RtpPacket(96, number % 3 == 2, number, time_stamp, payload), number)
        assert found is None or len(found.data) <= 8 * size + 8


@given(st.text(max_size=300), st.text(max_size=40))
def test_any_text_describes_a_video_or_none(text: str, base: str) -> None:
    for description in (text, SDP + text, SDP.replace("track1", text)):
        try:
            video = video_of(description, base)
        except NoVideo:
            continue
        assert 0 < video.rate < 10**9

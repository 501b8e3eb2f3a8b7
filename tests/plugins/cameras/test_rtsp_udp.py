"""A network camera by UDP: packets overtake each other, come twice, or are lost."""

from __future__ import annotations

import socket
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from itertools import islice
from typing import Any

import pytest
from pydantic import ValidationError
from tests.plugins.cameras.attempts import one_of
from tests.plugins.cameras.recordings import context

pytest.importorskip("av", reason="av is not installed")
from tests.plugins.cameras.rtsp_frames import last
from tests.plugins.cameras.rtsp_server import SIZE, RtspCamera, encoded

from followspot_cameras.rtsp.datagrams import Datagrams
from followspot_cameras.rtsp.stage import Rtsp

PATIENT = 5.0
"""A wait in which every packet of loopback comes, s."""


def stage(camera: RtspCamera, said: list[str], lost: Counter[str] | None = None, **params: Any) -> Rtsp:
    made = context("color", SIZE, warn=said.append)
    if lost is not None:
        made = replace(made, lost=lambda kind, number: lost.update({kind: number}))
    return Rtsp(made, url=camera.url, transport="udp", **params)


class Overtaking:
    """Every fifth packet comes after the next one, and every seventh comes twice."""

    def __init__(self) -> None:
        self._held: list[bytes] = []

    def __call__(self, number: int, packet: bytes) -> Sequence[bytes]:
        if number % 5 == 1:
            self._held = [packet]
            return []
        late, self._held = self._held, []
        return [packet, *([packet] if number % 7 == 0 else []), *late]


def test_capture_times_are_exact_while_packets_overtake_each_other_and_come_twice() -> None:
    def attempt() -> bool:
        said: list[str] = []
        lost: Counter[str] = Counter()
        with RtspCamera(shift=0.25, latency=0.04, fate=Overtaking()) as camera:
            source = stage(camera, said, lost, jitter_buffer=PATIENT)
            frames = last(20, source.process(), camera, within=5.0)
            source.close()
        assert frames
        return +lost == {}

    assert one_of(4, attempt)


@pytest.mark.parametrize("which", ["first", "middle", "last"])
def test_a_lost_packet_costs_the_picture_that_it_belongs_to(which: str) -> None:
    """Of each group of ten pictures, one packet of the fourth is lost."""
    units = [sum(-(-(len(unit) - 1) // 300) if len(unit) > 300 else 1 for unit in p) for p in encoded()]
    place = sum(units[:3]) + {"first": 0, "middle": units[3] // 2, "last": units[3] - 1}[which]

    def lossy(number: int, packet: bytes) -> Sequence[bytes]:
        return [] if number % sum(units) == place else [packet]

    said: list[str] = []
    lost: Counter[str] = Counter()
    with RtspCamera(fate=lossy, reports=None) as camera:
        source = stage(camera, said, lost, jitter_buffer=0.01, wait_for_report=0)
        frames = list(islice(source.process(), 27))
        source.close()
    assert +lost == {"packet_loss": 3}
    assert units[3] > 2
    assert len(frames) == 27


def test_a_camera_that_does_not_send_by_udp_is_told_in_its_words() -> None:
    said: list[str] = []
    with RtspCamera(takes_udp=False) as camera:
        source = stage(camera, said)
        with pytest.raises(ConnectionError, match="answers SETUP with 461 Unsupported Transport"):
            next(source.session())


def test_a_server_that_ends_is_gone_at_once() -> None:
    said: list[str] = []
    with RtspCamera() as camera:
        source = stage(camera, said, wait_for_report=0, read_timeout=60)
        frames = source.process()
        next(frames)
    with RtspCamera(port=camera.port):
        next(frames)
        source.close()
    told = [text for text in said if "clock" not in text]  # a busy machine makes the clock look late
    assert told[0].endswith("; connecting again until it answers")
    assert "no picture came" not in told[0]
    assert "is back after" in told[1]


class Session:
    """What the ports need of a connection of RTSP, whose server has nothing to say."""

    own_address = peer = "127.0.0.1"

    def __init__(self) -> None:
        self._ends = socket.socketpair()
        self.fileno = self._ends[0].fileno

    def close(self) -> None:
        for end in self._ends:
            end.close()


@pytest.mark.parametrize(("told", "taken"), [("", b"camera"), ("RTP/AVP;source=127.0.0.2", b"other!")])
def test_packets_come_from_the_camera_or_from_where_it_says(told: str, taken: bytes) -> None:
    session: Any = Session()
    with closing(session), closing(Datagrams(session, wait=PATIENT)) as ports:
        ports.agreed(told)
        there = int(ports.wanted.partition("client_port=")[2].partition("-")[0])
        assert there % 2 == 0
        for address, text in (("127.0.0.2", b"other!"), ("127.0.0.1", b"camera")):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
                sender.bind((address, 0))
                sender.sendto(b"\x80\x60\0\1" + text, ("127.0.0.1", there))
        found = ports.packet(PATIENT)
    assert found is not None
    assert found.data[4:] == taken


def test_a_protected_address_is_not_read_unprotected() -> None:
    with pytest.raises(ValidationError, match="nothing protects them"):
        Rtsp(context(), url="rtsps://127.0.0.1/cam", transport="udp")

"""What a show receives by Open Sound Control, by programs that are not ours: oscdump and python-osc."""

from __future__ import annotations

import shutil
import socket
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pythonosc.osc_packet import OscPacket
from tests.plugins.sinks.shows import ROOM, posed, received, tracks

from followspot import Context, Header
from followspot.messages import stamped
from followspot.people import Skeletons
from followspot_sinks.osc import Osc, OscSkeletons


@pytest.mark.skipif(shutil.which("oscdump") is None, reason="needs oscdump (package liblo-tools)")
def test_oscdump_prints_what_was_tracked() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    dump = subprocess.Popen(["oscdump", "-L", str(port)], stdout=subprocess.PIPE, text=True)
    assert dump.stdout is not None
    sink = Osc(Context(room=ROOM), port=port)
    sink.setup()
    try:
        while not listening(port):
            assert dump.poll() is None
        sink.process(tracks(0, 0, 2))
        lines = [" ".join(dump.stdout.readline().split()[1:]) for _ in range(7)]
    finally:
        dump.kill()
        dump.wait()
        sink.close()
    assert lines == [
        "/followspot/1/tracked f 1.000000",
        "/followspot/1/position fff 1.000000 -2.000000 0.500000",
        "/followspot/1/velocity fff 0.250000 0.000000 0.000000",
        "/followspot/2/tracked f 0.000000",
        "/followspot/3/tracked f 1.000000",
        "/followspot/3/position fff 3.000000 -2.000000 0.500000",
        "/followspot/3/velocity fff 0.250000 0.000000 -2.000000",
    ]


def listening(port: int) -> bool:
    """Whether some program has the UDP port; asking by binding it would take it from that program."""
    tables = [Path(f"/proc/net/{name}").read_text() for name in ("udp", "udp6")]
    return any(f":{port:04X} " in table for table in tables)


def test_osc_has_an_address_for_orientations_that_are_known(receiver: socket.socket) -> None:
    sink = Osc(Context(room=ROOM), port=receiver.getsockname()[1])
    packets = received(sink, [posed(0, None, 0, 1), posed(1, (0, 0, np.pi / 2), 0)], receiver)
    first, second = ([m.message for m in OscPacket(packet).messages] for packet in packets)
    assert not [m for m in first if m.address.endswith("orientation")]
    (found,) = [m for m in second if m.address.endswith("orientation")]
    assert found.address == "/followspot/1/orientation"
    assert found.params == pytest.approx([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])


def test_a_quaternion_that_is_none_is_not_sent(receiver: socket.socket) -> None:
    for wrong in (0.0, np.inf, 1e300):
        bad = stamped(replace(posed(0, None, 0), quaternion=np.full((1, 4), wrong)), Header("track", 0, 0))
        sink = Osc(Context(room=ROOM), port=receiver.getsockname()[1])
        (packet,) = received(sink, [bad], receiver)
        assert not [m for m in OscPacket(packet).messages if m.message.address.endswith("orientation")]


def skeletons(seconds: float, *persons: int) -> Skeletons:
    """Each person has a wrist, one whose name no address can have, and a nose whose place is not known."""
    count = len(persons)
    message = Skeletons(
        labels=("left_wrist", "right/wrist", "nose"),
        person=np.repeat(persons, 3).astype("i4"),
        label=np.tile([0, 1, 2], count).astype("i4"),
        xyz=np.tile([[1.0, 2.0, 0.5], [1.5, 2.0, 0.5], [np.nan, 0.0, 0.0]], (count, 1)),
        covariance=np.zeros((3 * count, 3, 3)),
        views=np.ones(3 * count, "i4"),
    )
    return stamped(message, Header("pose", 0, round(seconds * 1e9)))


def told(packets: list[bytes]) -> list[tuple[str, list[float]]]:
    found = [(m.message.address, m.message.params) for packet in packets for m in OscPacket(packet).messages]
    return [(address, list(values)) for address, values in found]


def test_joints_of_a_person_have_an_address_each(receiver: socket.socket) -> None:
    sink = OscSkeletons(port=receiver.getsockname()[1])
    assert told(received(sink, [skeletons(0.0, 3)], receiver)) == [
        ("/followspot/3/tracked", [1.0]),
        ("/followspot/3/joint/left_wrist", [1.0, 2.0, 0.5]),
        ("/followspot/3/joint/right_wrist", [1.5, 2.0, 0.5]),
    ]


def test_a_person_who_has_left_is_told_for_three_seconds(receiver: socket.socket) -> None:
    sink = OscSkeletons(port=receiver.getsockname()[1])
    left = [skeletons(0.0, 3), skeletons(3.0), skeletons(3.001)]
    assert [told([packet])[0] for packet in received(sink, list(left), receiver)] == [
        ("/followspot/3/tracked", [1.0]),
        ("/followspot/3/tracked", [0.0]),
    ]


def test_it_is_told_for_a_while_that_a_person_has_left(receiver: socket.socket) -> None:
    """The network may lose a datagram, and the worker may be started again meanwhile."""
    sink = OscSkeletons(port=receiver.getsockname()[1])
    frames = [skeletons(0.0, 3, 4), skeletons(1.0, 4), skeletons(3.5, 4), skeletons(4.0, 3, 4)]
    packets = [told([packet]) for packet in received(sink, list(frames), receiver)]
    assert [packet[0] for packet in packets] == [
        ("/followspot/3/tracked", [1.0]),
        ("/followspot/4/tracked", [1.0]),
        ("/followspot/3/tracked", [0.0]),
        ("/followspot/4/tracked", [1.0]),
        ("/followspot/4/tracked", [1.0]),
        ("/followspot/3/tracked", [1.0]),
        ("/followspot/4/tracked", [1.0]),
    ]
    assert [len(packet) for packet in packets] == [3, 3, 1, 3, 3, 3, 3]
    second = OscSkeletons(port=receiver.getsockname()[1])
    second.setup()
    second.restore(sink.state())
    second.process(skeletons(5.0))
    assert told([receiver.recv(65536) for _ in range(2)]) == [
        ("/followspot/3/tracked", [0.0]),
        ("/followspot/4/tracked", [0.0]),
    ]
    second.close()

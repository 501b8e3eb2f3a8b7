"""Messages as JSON datagrams, and what is said if the network takes none."""

from __future__ import annotations

import json
import socket

import pytest
from tests.plugins.sinks.shows import ROOM, posed, received, tracks

from followspot import Context
from followspot.errors import InputError
from followspot_sinks.osc import Osc
from followspot_sinks.udp_json import UdpJson


def test_any_message_as_json(receiver: socket.socket) -> None:
    sink = UdpJson(Context(), port=receiver.getsockname()[1])
    (packet,) = received(sink, [tracks(3, 1)], receiver)
    told = json.loads(packet)
    (row,) = told["rows"]
    assert (told["type"], told["seq"], row["object"]) == ("Tracks", 3, "1")  # the room has no targets
    assert [row[axis] for axis in "xyz"] == [2.0, -2.0, 0.5]


def test_a_message_too_long_for_a_datagram_is_told_of_once(receiver: socket.socket) -> None:
    warnings: list[str] = []
    sink = UdpJson(Context(warn=warnings.append), port=receiver.getsockname()[1])
    assert received(sink, [tracks(frame, *range(3000)) for frame in range(3)], receiver) == []
    assert len(warnings) == 1


def test_a_network_that_takes_nothing_is_told_of_and_the_graph_goes_on() -> None:
    warnings: list[str] = []
    sink = UdpJson(Context(warn=warnings.append), host="255.255.255.255", port=9)
    sink.setup()
    for frame in range(4):
        sink.process(tracks(frame, 1))
    sink.close()
    assert len(warnings) == 2
    assert "4 packets for 255.255.255.255:9 were not sent" in warnings[1]


def test_an_unknown_host_is_named() -> None:
    with pytest.raises(InputError, match=r"no-such-host\.invalid"):
        Osc(Context(room=ROOM), host="no-such-host.invalid").setup()


def test_orientations_in_json_datagrams(receiver: socket.socket) -> None:
    sink = UdpJson(Context(room=ROOM), port=receiver.getsockname()[1])
    known, unknown = (
        json.loads(p)["rows"][0]
        for p in received(sink, [posed(0, (0, 0, 0), 1), posed(1, None, 1)], receiver)
    )
    assert (known["object"], known["qw"], known["qz"], known["orientation_sigma"]) == ("green", 1.0, 0.0, 0.0)
    assert unknown["qw"] is None

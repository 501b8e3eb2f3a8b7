"""What lights receive by PosiStageNet, decoded by pypsn."""

from __future__ import annotations

import socket

import numpy as np
import pypsn
import pytest
from tests.plugins.sinks.shows import ROOM, posed, poses, received, tracks

from followspot import Context, Header, Room, Target
from followspot.errors import InputError
from followspot.messages import stamped
from followspot.tracking import Tracks
from followspot_sinks.psn.stage import Psn, PsnPoses


def test_lights_receive_places_speeds_and_names(receiver: socket.socket) -> None:
    sink = Psn(Context(room=ROOM), host="127.0.0.1", port=receiver.getsockname()[1])
    first, names, second, third, again = received(sink, [tracks(0, 0, 2), tracks(1, 1), tracks(2)], receiver)
    data = pypsn.parse_psn_packet(first)
    assert (data.info.version_high, data.info.packet_count, data.info.frame_id) == (2, 1, 0)
    assert [t.id for t in data.trackers] == [1, 2, 3]
    assert list(data.trackers[2].pos) == [3.0, 0.5, -2.0]  # x, z, y of the room: y is up
    assert list(data.trackers[2].speed) == [0.25, -2.0, 0.0]
    assert [t.status for t in data.trackers] == [1.0, 0.0, 1.0]
    info = pypsn.parse_psn_packet(names)
    assert [(t.tracker_id, t.tracker_name) for t in info.trackers] == [
        (1, b"red"),
        (2, b"green"),
        (3, b"blue"),
    ]
    later = pypsn.parse_psn_packet(second)
    assert [t.status for t in later.trackers] == [0.0, 1.0, 0.0]
    assert list(later.trackers[2].pos) == [3.0, 0.5, -2.0]  # where it was last
    assert later.trackers[0].timestamp == 500_000  # µs
    assert pypsn.parse_psn_packet(third).info.frame_id == 2
    assert pypsn.parse_psn_packet(again).trackers[0].tracker_name == b"red"  # a second later


def test_a_card_that_this_computer_does_not_have_is_told_in_words() -> None:
    lights = Psn(Context("lights", ROOM), interface="192.0.2.7")
    with pytest.raises(InputError, match=r"from 192\.0\.2\.7: Cannot assign requested address\n"):
        lights.setup()


def test_lights_never_turn_to_a_number_that_is_none(receiver: socket.socket) -> None:
    """A place that is NaN is sent as the last one that was known, and as not tracked now."""
    unknown = np.full((1, 3), np.nan)
    lost = Tracks(np.array([0], "i4"), np.ones(1, "u1"), unknown, unknown, unknown)
    sink = Psn(Context(room=ROOM), host="127.0.0.1", port=receiver.getsockname()[1])
    *_, packet = received(sink, [tracks(0, 0), stamped(lost, Header("track", 1, 500_000_000))], receiver)
    (red, *_) = pypsn.parse_psn_packet(packet).trackers
    assert (list(red.pos), red.status) == ([1.0, 0.5, -2.0], 0.0)


def test_many_trackers_are_split_into_packets_that_fit_an_ethernet_frame(receiver: socket.socket) -> None:
    room = Room(targets={f"t{n}": Target(f"t{n}", 0.1) for n in range(100)})
    sink = Psn(Context(room=room), host="127.0.0.1", port=receiver.getsockname()[1])
    packets = received(sink, [tracks(0, *range(100))], receiver)
    assert max(map(len, packets)) <= 1472
    data = [p for p in map(pypsn.parse_psn_packet, packets) if isinstance(p, pypsn.psn_data_packet)]
    assert {p.info.packet_count for p in data} == {len(data)}
    assert [t.id for p in data for t in p.trackers] == list(range(1, 101))


def test_a_heading_turns_about_the_axis_that_is_up_on_stage(receiver: socket.socket) -> None:
    for axes, turned in (
        ("x z y", [0.0, -0.5, 0.0]),
        ("+x +z +y", [0.0, -0.5, 0.0]),
        ("x z -y", [0.0, 0.5, 0.0]),
        ("x y z", [0.0, 0.0, 0.5]),
    ):
        sink = PsnPoses(Context(), host="127.0.0.1", port=receiver.getsockname()[1], slots=1, axes=axes)
        packet = received(sink, [poses(0.0, 7)], receiver)[0]
        assert list(pypsn.parse_psn_packet(packet).trackers[0].ori) == pytest.approx(turned), axes


@pytest.mark.parametrize("axes", ["x x z", "x y", "-z -z -z"])
def test_axes_that_are_no_permutation_are_refused(axes: str) -> None:
    with pytest.raises(ValueError, match=r"axes"):
        Psn(Context(room=ROOM), host="127.0.0.1", axes=axes)


@pytest.mark.parametrize(
    ("axes", "turned"),
    [("x z y", [-0.1, -0.3, -0.2]), ("x z -y", [0.1, 0.3, -0.2]), ("x y z", [0.1, 0.2, 0.3])],
)
def test_lights_receive_orientations_in_the_axes_of_the_stage(
    axes: str, turned: list[float], receiver: socket.socket
) -> None:
    sink = Psn(Context(room=ROOM), host="127.0.0.1", port=receiver.getsockname()[1], axes=axes)
    first, _, second, third = received(
        sink, [posed(0, (0.1, 0.2, 0.3), 0), posed(1, None, 0, 1), tracks(1, 0, 2)], receiver
    )
    for packet in (first, second, third):  # the last that was known, as places are
        red, green, _ = pypsn.parse_psn_packet(packet).trackers
        assert list(red.ori) == pytest.approx(turned)
        assert list(green.ori) == [0, 0, 0]

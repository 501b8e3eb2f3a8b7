"""What a show receives, by programs that are not ours: liblo's oscdump, and a PosiStageNet decoder."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypsn
import pytest
from pythonosc.osc_packet import OscPacket

from followspot import Context, Header, Message, Room, Target
from followspot.control.checkpoint import state_from_data, state_to_data
from followspot.errors import InputError
from followspot.inertial import PosedTracks
from followspot.messages import stamped
from followspot.people import Poses, Skeletons
from followspot.rotation import from_rotation_vector
from followspot.tracking import Tracks
from followspot_sinks.osc import Osc, OscPoses, OscSkeletons
from followspot_sinks.psn.stage import Psn, PsnPoses
from followspot_sinks.slots import PersonSlots
from followspot_sinks.udp_json import UdpJson

ROOM = Room(targets={name: Target(name, 0.1) for name in ("red", "green", "blue")})


def tracks(frame: int, *targets: int) -> Tracks:
    count = len(targets)
    message = Tracks(
        target=np.array(targets, "i4"),
        state=np.ones(count, "u1"),
        xyz=np.array([[t + 1.0, -2.0, 0.5] for t in targets]).reshape(count, 3),
        velocity=np.array([[0.25, 0.0, -t] for t in targets]).reshape(count, 3),
        sigma=np.full((count, 3), 0.004),
    )
    return stamped(message, Header("track", frame, frame * 500_000_000))


def poses(seconds: float, *persons: int) -> Poses:
    count = len(persons)
    message = Poses(
        camera="",
        person=np.array(persons, "i4"),
        state=np.ones(count, "u1"),
        xy=np.array([[person, seconds] for person in persons], float).reshape(count, 2),
        height=np.full(count, 1.75),
        heading=np.full(count, 0.5),
        pan=np.zeros(count),
        tilt=np.zeros(count),
        sigma=np.zeros((count, 6)),
        confidence=np.ones(count),
    )
    return stamped(message, Header("pose", 0, round(seconds * 1e9)))


@pytest.fixture
def receiver() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.bind(("127.0.0.1", 0))
        own.settimeout(5)
        yield own


def received(
    sink: Osc | OscPoses | OscSkeletons | Psn | PsnPoses | UdpJson,
    messages: list[Message],
    own: socket.socket,
) -> list[bytes]:
    """The datagrams that the sink sends for these messages."""
    sink.setup()
    packets = []
    for message in messages:
        sink.process(message)  # type: ignore[arg-type]
    sink.close()
    own.setblocking(False)
    while True:
        try:
            packets.append(own.recv(65536))
        except BlockingIOError:
            return packets


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


def test_nobody_whose_place_is_unknown_takes_a_slot() -> None:
    gone = replace(poses(0.0, 4), heading=np.array([np.nan]))
    assert PersonSlots(2, hold=3.0).after(stamped(gone, Header("pose", 0, 0))).names == ("", "")


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


def test_a_person_keeps_a_slot_until_gone_for_good() -> None:
    slots = PersonSlots(2, hold=3.0)
    assert slots.after(poses(0.0, 4, 9)).names == ("person 4", "person 9")
    shown = slots.after(poses(0.5, 9))
    assert shown.known.tolist() == [False, True]
    assert shown.velocity[1].tolist() == [0.0, 1.0, 0.0]
    assert shown.position[0].tolist() == [4.0, 0.0, 1.75]  # where person 4 was last
    assert slots.after(poses(1.0, 9, 5)).known.tolist() == [False, True]  # no slot is free yet
    assert slots.after(poses(3.5, 9, 5)).names == ("person 5", "person 9")


def test_persons_keep_their_slots_when_the_worker_is_started_again() -> None:
    slots = PersonSlots(3, hold=3.0)
    slots.after(poses(0.0, 4, 9, 5))
    slots.after(poses(3.5, 9, 5))
    sent = slots.after(poses(3.6, 5))
    again = PersonSlots(3, hold=3.0)
    again.restore(state_from_data(json.loads(json.dumps(state_to_data(slots.state())))))
    resumed = again.after(poses(3.7, 5, 9))
    assert resumed.names == ("", "person 9", "person 5")
    assert resumed.velocity[2].tolist() == pytest.approx([0, 1, 0])
    assert resumed.position[0].tolist() == sent.position[0].tolist(), "it stays where it was"
    fewer = PersonSlots(2, hold=3.0)
    fewer.restore(slots.state())
    assert fewer.after(poses(3.7, 9, 6)).names == ("person 6", "person 9")


@pytest.mark.parametrize("kind", [Osc, Psn])
def test_a_target_that_is_not_tracked_stays_where_it_was_when_the_worker_is_started_again(
    kind: type[Osc | Psn], receiver: socket.socket
) -> None:
    sink, again = (kind(Context(room=ROOM), port=receiver.getsockname()[1]) for _ in range(2))
    received(sink, [tracks(0, 0, 1)], receiver)
    again.setup()
    again.restore(sink.state())
    again.process(tracks(1, 0))
    before, after = sink.keeper.slots, again.keeper.slots
    assert after.position[1].tolist() == before.position[1].tolist() != [0.0, 0.0, 0.0]
    assert (after.names, after.known.tolist()) == (("red", "green", "blue"), [True, False, False])
    again.close()


def test_a_person_who_is_seen_keeps_a_slot_that_is_held_for_nobody() -> None:
    """Frames are farther apart than slots are held, and person 5 comes as person 4 leaves."""
    slots = PersonSlots(2, hold=0.0)
    slots.after(poses(0.0, 4, 9))
    assert slots.after(poses(0.5, 9)).names == ("", "person 9")
    shown = slots.after(poses(1.0, 9, 5))
    assert shown.names == ("person 5", "person 9")
    later = slots.after(poses(1.5, 9, 7))
    assert later.names == ("person 7", "person 9")
    assert later.velocity.tolist() == [[0, 0, 0], [0, 1, 0]]  # not from the place of person 5


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


def posed(frame: int, turn: tuple[float, float, float] | None, *targets: int) -> PosedTracks:
    """Tracks of targets that are all turned by a rotation vector; None: nobody knows how."""
    plain = tracks(frame, *targets)
    one = np.full(4, np.nan) if turn is None else from_rotation_vector(np.array(turn))
    columns = {column.name: getattr(plain, column.name) for column in Tracks.columns}
    count = len(targets)
    message = PosedTracks(**columns, quaternion=np.tile(one, (count, 1)), orientation_sigma=np.zeros(count))
    return stamped(message, plain.header)


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


def test_orientations_in_json_datagrams(receiver: socket.socket) -> None:
    sink = UdpJson(Context(room=ROOM), port=receiver.getsockname()[1])
    known, unknown = (
        json.loads(p)["rows"][0]
        for p in received(sink, [posed(0, (0, 0, 0), 1), posed(1, None, 1)], receiver)
    )
    assert (known["object"], known["qw"], known["qz"], known["orientation_sigma"]) == ("green", 1.0, 0.0, 0.0)
    assert unknown["qw"] is None


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

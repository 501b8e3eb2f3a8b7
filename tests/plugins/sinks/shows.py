"""Messages for shows, and the datagrams that a sink sends for them."""

from __future__ import annotations

import socket

import numpy as np

from followspot import Header, Message, Room, Target
from followspot.inertial import PosedTracks
from followspot.messages import stamped
from followspot.people import Poses
from followspot.rotation import from_rotation_vector
from followspot.tracking import Tracks
from followspot_sinks.osc import Osc, OscPoses, OscSkeletons
from followspot_sinks.psn.stage import Psn, PsnPoses
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


def posed(frame: int, turn: tuple[float, float, float] | None, *targets: int) -> PosedTracks:
    """Tracks of targets that are all turned by a rotation vector; None: nobody knows how."""
    plain = tracks(frame, *targets)
    one = np.full(4, np.nan) if turn is None else from_rotation_vector(np.array(turn))
    columns = {column.name: getattr(plain, column.name) for column in Tracks.columns}
    count = len(targets)
    message = PosedTracks(**columns, quaternion=np.tile(one, (count, 1)), orientation_sigma=np.zeros(count))
    return stamped(message, plain.header)

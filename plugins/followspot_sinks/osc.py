"""Targets and persons as Open Sound Control, as visual artists patch it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import numpy as np
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from followspot import Field
from followspot.frame_times import SECOND
from followspot.people import Poses, Skeletons
from followspot.plain_values import from_plain, to_plain
from followspot.tracking import Tracks
from followspot_sinks.datagrams import DatagramSink
from followspot_sinks.slots.kept import KeepsSlots
from followspot_sinks.slots.persons import PersonSlotParams, PersonSlots
from followspot_sinks.slots.slots import Slots, sendable
from followspot_sinks.slots.targets import TargetSlots

_NOT_IN_ADDRESS = re.compile(r"[^\w.-]")
_UNTRACKED_TIME = 3 * SECOND
"""For how long a person who has left is sent as not tracked, ns: the network may lose a datagram."""


class OscSink(DatagramSink):
    """Base of the OSC sinks: a bundle a frame, one address for each group of values, floats only."""

    class Params(DatagramSink.Params):
        """The receiver and the addresses."""

        prefix: str = Field("/followspot", pattern=r"^(/[\w.-]+)+$", description="start of every address")

    params: Params

    def send(self, slots: Slots, heading: bool) -> None:
        """Send one bundle."""
        if self.network is not None:
            self.network.send(bundle(self.params.prefix, slots, heading))


class Osc(KeepsSlots[TargetSlots], OscSink):
    """Send each target of the room to slot 1, 2, ... in the order of the room file.

    `/followspot/1/tracked` 1 or 0, while its place is known `/followspot/1/position` x y z (m) and
    `/followspot/1/velocity` vx vy vz (m/s), and of tracks with orientations `/followspot/1/orientation`
    qw qx qy qz.
    """

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.keeper = TargetSlots(tuple(self.room.targets))

    def process(self, tracks: Tracks) -> None:
        """Send one frame."""
        self.send(self.keeper.after(tracks), heading=False)


class OscPoses(KeepsSlots[PersonSlots], OscSink):
    """Send each person in a slot of its own: position of the head's top, velocity, heading.

    As `sinks.osc`, and `/followspot/1/heading` (rad, counter-clockwise from the room's x axis).
    """

    class Params(OscSink.Params, PersonSlotParams):
        """The receiver and the slots."""

    params: Params

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.keeper = PersonSlots(self.params.slots, self.params.hold_time)

    def process(self, poses: Poses) -> None:
        """Send one frame."""
        self.send(self.keeper.after(poses), heading=True)


class OscSkeletons(OscSink):
    """Send a bundle with the joints of each person: `/followspot/1/joint/left_wrist` x y z (m).

    1 is the person's number. Joints without a known position are not sent. `/followspot/1/tracked` is 1 while
    at least one joint is known, and 0 for 3 s after that.
    """

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.seen: dict[int, int] = {}

    def process(self, skeletons: Skeletons) -> None:
        """Send one frame."""
        time = skeletons.header.time
        known = skeletons.where(sendable(skeletons.xyz))
        lately = {person: seen for person, seen in self.seen.items() if time - seen <= _UNTRACKED_TIME}
        self.seen = lately | dict.fromkeys(np.unique(known.person).tolist(), time)
        if self.network is not None:
            for person in sorted(self.seen):
                own = known.where(known.person == person)
                self.network.send(joint_bundle(self.params.prefix, person, own))

    def state(self) -> Any:
        """When each person was seen last, ns: those who leave meanwhile are sent as not tracked, too."""
        return to_plain(self.seen)

    def restore(self, state: Any) -> None:
        """Carry on from this state."""
        self.seen = from_plain(dict[int, int], state)


def joint_bundle(prefix: str, person: int, joints: Skeletons) -> bytes:
    """One OSC bundle: whether a person is tracked, and a message for each joint.

    joints: of the person, none if it is not tracked; characters that an address cannot have become _.
    """
    build = OscBundleBuilder(IMMEDIATELY)
    names = [_NOT_IN_ADDRESS.sub("_", name) for name in joints.labels]
    _add(build, f"{prefix}/{person}/tracked", [float(len(joints.person) > 0)])
    for label, xyz in zip(joints.label, joints.xyz, strict=True):
        _add(build, f"{prefix}/{person}/joint/{names[label]}", xyz.tolist())
    return build.build().dgram


def bundle(prefix: str, slots: Slots, heading: bool) -> bytes:
    """One OSC bundle; slots are numbered from 1."""
    build = OscBundleBuilder(IMMEDIATELY)
    oriented = slots.oriented.tolist()
    for row, known in enumerate(slots.known.tolist()):
        address = f"{prefix}/{row + 1}"
        _add(build, f"{address}/tracked", [float(known)])
        if known:
            _add(build, f"{address}/position", slots.position[row].tolist())
            _add(build, f"{address}/velocity", slots.velocity[row].tolist())
            if oriented[row]:
                _add(build, f"{address}/orientation", slots.quaternion[row].tolist())
            if heading:
                _add(build, f"{address}/heading", [float(slots.heading[row])])
    return build.build().dgram


def _add(build: OscBundleBuilder, address: str, values: Iterable[float]) -> None:
    message = OscMessageBuilder(address)
    for value in values:
        message.add_arg(value, OscMessageBuilder.ARG_TYPE_FLOAT)
    build.add_content(message.build())

"""Targets and persons as PosiStageNet 2, the standard by which stage lights follow."""

from __future__ import annotations

from pydantic import field_validator

from followspot import Field, OutputHost
from followspot.frame_times import SECOND
from followspot.people import Poses
from followspot.rotation import signed_axes
from followspot.tracking import Tracks
from followspot_sinks.datagrams import DatagramSink
from followspot_sinks.psn.packets import data_packets, info_packets
from followspot_sinks.slots.kept import KeepsSlots
from followspot_sinks.slots.persons import PersonSlotParams, PersonSlots
from followspot_sinks.slots.slots import Slots
from followspot_sinks.slots.targets import TargetSlots


class PsnSink(DatagramSink):
    """Base of the PSN sinks: data packets for every frame, the names once a second of capture time."""

    class Params(DatagramSink.Params):
        """The receiver, and the axes of the stage in the room."""

        host: OutputHost = Field(
            "236.10.10.10", description="receiver; by default the multicast group of the standard"
        )
        port: int = Field(56565, ge=1, le=65535, unit="1", description="UDP port of the receiver")
        system_name: str = Field(
            "followspot", min_length=1, max_length=64, description="name that receivers show"
        )
        axes: str = Field(
            "x z y",
            pattern=r"^[+-]?[xyz] [+-]?[xyz] [+-]?[xyz]$",
            description="the room's axes that are PSN's x (right), y (up) and z (depth)",
        )

        @field_validator("axes")
        @classmethod
        def _check_axes(cls, value: str) -> str:
            signed_axes(value)
            return value

    params: Params

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.axes = signed_axes(self.params.axes)
        self.frame = 0
        self.named_at = -SECOND

    def send(self, slots: Slots, time: int) -> None:
        """Send one frame, with capture time in ns."""
        if self.network is None:
            return
        packets = data_packets(slots, self.axes, time, self.frame)
        if time - self.named_at >= SECOND:
            packets += info_packets(self.params.system_name, slots.names, time, self.frame)
            self.named_at = time
        for packet in packets:
            self.network.send(packet)
        self.frame += 1


class Psn(KeepsSlots[TargetSlots], PsnSink):
    """Send each target as tracker 1, 2, ... in the order of the room file; status 1: its place is known.

    Its orientation is sent if the tracks have one.
    """

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.keeper = TargetSlots(tuple(self.room.targets))

    def process(self, tracks: Tracks) -> None:
        """Send one frame."""
        self.send(self.keeper.after(tracks), tracks.header.time)


class PsnPoses(KeepsSlots[PersonSlots], PsnSink):
    """Send each person as a tracker of its own: the head's top, and the heading."""

    class Params(PsnSink.Params, PersonSlotParams):
        """The receiver and the slots."""

    params: Params

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.keeper = PersonSlots(self.params.slots, self.params.hold_time)

    def process(self, poses: Poses) -> None:
        """Send one frame."""
        self.send(self.keeper.after(poses), poses.header.time)

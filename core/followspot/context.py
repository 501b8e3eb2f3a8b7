"""The context of a stage: its view of the run, and what it can ask of the run."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np

from followspot.messages import Array, Message
from followspot.room import Camera, Member, Room

SourceLoss = Literal["packet_loss", "device_overrun", "gap"]
"""How a frame of a device is lost before its source has it."""


def _no_warning(text: str) -> None:
    """Drop the warning: outside a run, none is shown."""


def _no_loss(kind: SourceLoss, number: int) -> None:
    """Count nothing: outside a run there is no ledger."""


def _fresh(shape: tuple[int, ...], dtype: str) -> Array:
    """A new array: outside a run there is no shared memory."""
    return np.empty(shape, dtype)


def _sleep(seconds: float) -> bool:
    """Wait, s: outside a run nothing ends the wait."""
    time.sleep(seconds)
    return True


class Post(Protocol):
    """Non-blocking channel from a tap to observers on other hosts."""

    @property
    def wanted(self) -> bool:
        """True if an observer subscribes."""

    def send(self, packet: bytes) -> None:
        """Send a packet, or drop it if the network is congested."""

    def close(self) -> None:
        """Close the channel."""


@dataclass(frozen=True)
class Context:
    """The stage's view of its run. Every field has a default, for tests without a run."""

    name: str = "stage"
    room: Room = Room()
    member: Member | None = None
    """The camera, sensor, target or value of a tag that this instance serves, if the graph says `each`."""
    out: Path = Path()
    """The run's output folder."""
    seed: int = 0
    receives: tuple[type[Message], ...] = ()
    """Types of the messages that the edges bring, each once."""
    warn: Callable[[str], None] = _no_warning
    """Report a problem that does not stop the run; the user sees it with the stage's name, now and at the
    end."""
    loan: Callable[[tuple[int, ...], str], Array] = _fresh
    """An array (shape, dtype) to compute the output into, in shared memory if a reader on this host uses
    it."""
    pause: Callable[[float], bool] = _sleep
    """Wait (s), for a live source, which has a thread of its own. Returns False at once if the run is ending:
    the source should return then. Any other source would hold up its whole worker: it names the time at which
    a message is due (`at`) instead."""
    resumed: bool = False
    """True if an earlier instance of the stage has worked in this run: a sink keeps what that one wrote."""
    lost: Callable[[SourceLoss, int], None] = _no_loss
    """Count frames that the device made and that a live source did not get: packets were missing
    (`packet_loss`), the device or its driver gave them up because they were not taken in time
    (`device_overrun`), or the numbers of the frames leave them out (`gap`). The ledger shows them as lost at
    the source."""
    run_begun: Callable[[], int] = time.monotonic_ns
    """When the stages of this host began together, ns of `time.monotonic_ns`."""
    post: Post | None = None
    """Channel to the observers of a tap on another host than the operator's."""

    def begun(self) -> int:
        """The time from which a source that plays at a pace counts, ns of `time.monotonic_ns`.

        It is the time at which all sources of this host began, in whichever workers they are; now for a
        source that comes later (`resumed`).
        """
        return time.monotonic_ns() if self.resumed else self.run_begun()

    @classmethod
    def serving(cls, camera: Camera, room: Room | None = None, **rest: Any) -> Context:
        """The context of an instance that serves a camera; without a room, in one of that camera alone."""
        found = Room(cameras={camera.name: camera}) if room is None else room
        return cls(room=found, member=Member("cameras", camera.name), **rest)

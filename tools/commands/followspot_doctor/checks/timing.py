"""Whether the cameras of a room take their pictures at the same time: all are watched for some seconds."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from followspot.errors import InputError
from followspot.frame_times import to_ns
from followspot.messages import UNSTAMPED, Array, Message
from followspot.plugins.registry import PluginError, load_stage
from followspot.room import Camera, Room
from followspot.room_file import load
from followspot_doctor.checks.cameras import MOST
from followspot_doctor.checks.source import tried
from followspot_doctor.finding import Finding, doubtful, fine, wrong
from followspot_doctor.spread import Spread, Timing, spread_of

SUBJECT = "timing of cameras"
SECONDS = 5.0
"""How long cameras are watched, from when all of them send pictures."""
CONNECTING = 10.0
"""Time that they have to begin, s."""
TOLERANCE = 4.0
"""Difference of capture times up to which stages match pictures if nothing else is said, ms."""
_EXAMPLE = "source: {uses: cameras.genicam, with: {camera: ...}}"
_REMEDY = (
    "trigger the cameras together, set `clock_offset` (followspot calibrate clocks), or give stages a larger "
    "tolerance"
)


def timing(path: str, seconds: float = SECONDS) -> Iterator[Finding]:
    """The rate and lateness of each live camera, and how far apart they are. seconds: of watching."""
    try:
        room = load(path)
    except InputError:
        return  # the check of the cameras reports it
    room = by_clocks(room)
    cameras = [camera for camera in room.cameras.values() if _is_live(camera)]
    if len(cameras) < 2:
        yield fine(SUBJECT, f"{len(cameras)} live cameras on this host: nothing to compare")
        return
    watch = Watch(len(cameras), seconds)
    with ThreadPoolExecutor(MOST) as pool:
        found = list(pool.map(lambda camera: _watched(camera, room, watch), cameras))
    times = {camera.name: t for camera, t in zip(cameras, found, strict=True) if len(t)}
    spread = spread_of(times) if len(times) > 1 else None
    if spread is None:
        counts = ", ".join(f"{camera.name} {len(t)}" for camera, t in zip(cameras, found, strict=True))
        text = f"too few pictures of one time: {counts}"
        yield wrong(SUBJECT, text, "see that all cameras send pictures, and by one clock")
        return
    yield from findings(spread)


def by_clocks(room: Room) -> Room:
    """The room whose pictures keep the times that their cameras' clocks tell, however they are matched."""
    return room if room.sync is None else replace(room, sync=replace(room.sync, match="time"))


def findings(spread: Spread) -> Iterator[Finding]:
    """A finding a camera, and one for all."""
    names = list(spread.cameras)
    for name, one in spread.cameras.items():
        if len(names) > 2:
            yield _judged(name, one, "the others")
        elif name == names[0]:
            yield fine(name, f"{one.rate:.4g} pictures/s; {names[1]} is compared with it")
        else:
            yield _judged(name, one, names[0])
    text = f"pictures of one moment lie {spread.usual:.3g} ms apart, 95 % of them within {spread.most:.3g} ms"
    yield fine(SUBJECT, text) if spread.most <= TOLERANCE else doubtful(SUBJECT, text, _REMEDY)


def _judged(name: str, one: Timing, others: str) -> Finding:
    side = "later" if one.late >= 0 else "earlier"
    lateness = f"{abs(one.late):.3g} ms {side} than {others}, jitter {one.jitter:.2g} ms"
    text = f"{one.rate:.4g} pictures/s, {lateness}"
    off = abs(one.late) > TOLERANCE or one.jitter > TOLERANCE
    return doubtful(name, text, _REMEDY) if off else fine(name, text)


def _is_live(camera: Camera) -> bool:
    """Whether the camera hangs on this host and delivers in its own time."""
    try:
        return camera.source is not None and not camera.host and load_stage(camera.source.uses).live
    except PluginError:
        return False


class Watch:
    """The time in which cameras are watched: `seconds` from when all of them have begun."""

    def __init__(self, cameras: int, seconds: float) -> None:
        self._missing, self._seconds, self._lock = cameras, seconds, threading.Lock()
        self.longest = CONNECTING + seconds
        """Time that the watch may take, s."""
        self.until = time.monotonic() + self.longest
        """When it ends, s by the steady clock."""

    def begin(self) -> None:
        """Note that one more camera sends pictures."""
        with self._lock:
            self._missing -= 1
            if not self._missing:
                self.until = min(self.until, time.monotonic() + self._seconds)


def _watched(camera: Camera, room: Room, watch: Watch) -> Array:
    """Capture times, (N,) int64 ns, with the camera's offset; times of arrival if it gives none."""
    offset = to_ns(camera.clock_offset)

    def take(messages: Iterator[Message]) -> Sequence[int]:
        times: list[int] = []
        for message in messages:
            header = message.header
            times.append(time.time_ns() if header is UNSTAMPED else header.time)
            if len(times) == 1:
                watch.begin()
            if time.monotonic() > watch.until:
                break
        return times

    found = tried(camera, room, take, _EXAMPLE, watch.longest + 1.0).taken
    return np.array(found or [], np.int64) + offset

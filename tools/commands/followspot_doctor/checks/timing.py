"""Whether the cameras of a room take their pictures at the same time: all are watched for some seconds."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from followspot.errors import InputError
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
"""How long cameras are watched, with the time that they need to connect."""
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
        return  # the check of the cameras tells it
    cameras = [camera for camera in room.cameras.values() if _is_live(camera)]
    if len(cameras) < 2:
        yield fine(SUBJECT, f"{len(cameras)} live cameras on this computer: nothing to compare")
        return
    with ThreadPoolExecutor(MOST) as pool:
        found = list(pool.map(lambda camera: _watched(camera, room, seconds), cameras))
    times = {camera.name: t for camera, t in zip(cameras, found, strict=True) if len(t)}
    spread = spread_of(times) if len(times) > 1 else None
    if spread is None:
        counts = ", ".join(f"{camera.name} {len(t)}" for camera, t in zip(cameras, found, strict=True))
        text = f"too few pictures of one time in {seconds:g} s: {counts}"
        yield wrong(SUBJECT, text, "see that all cameras send pictures, and by one clock")
        return
    yield from findings(spread)


def findings(spread: Spread) -> Iterator[Finding]:
    """A finding a camera, and one for all."""
    for name, one in spread.cameras.items():
        yield _judged(name, one, len(spread.cameras))
    text = f"pictures of one moment lie {spread.usual:.3g} ms apart, 95 % of them within {spread.most:.3g} ms"
    yield fine(SUBJECT, text) if spread.most <= TOLERANCE else doubtful(SUBJECT, text, _REMEDY)


def _judged(name: str, one: Timing, cameras: int) -> Finding:
    others = "the others" if cameras > 2 else "the first camera"
    side = "later" if one.late >= 0 else "earlier"
    lateness = f"{abs(one.late):.3g} ms {side} than {others}, jitter {one.jitter:.2g} ms"
    text = f"{one.rate:.4g} pictures/s, {lateness}"
    off = abs(one.late) > TOLERANCE or one.jitter > TOLERANCE
    return doubtful(name, text, _REMEDY) if off else fine(name, text)


def _is_live(camera: Camera) -> bool:
    """Whether the camera hangs on this computer and delivers in its own time."""
    try:
        return camera.source is not None and not camera.host and load_stage(camera.source.uses).live
    except PluginError:
        return False


def _watched(camera: Camera, room: Room, seconds: float) -> Array:
    """Capture times, (N,) int64 ns, with the camera's offset; of arrival where it tells none."""
    offset = round(camera.clock_offset * 1e9)
    until = time.monotonic() + seconds

    def take(messages: Iterator[Message]) -> Sequence[int]:
        times = []
        for message in messages:
            header = message.header
            times.append(time.time_ns() if header is UNSTAMPED else header.time)
            if time.monotonic() > until:
                break
        return times

    found = tried(camera, room, take, _EXAMPLE).taken
    return np.array(found or [], np.int64) + offset

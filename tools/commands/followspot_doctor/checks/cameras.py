"""One picture from every camera of a room, by the source that the room declares for it.

All are asked at once, as in a run: cameras that share a cable may do one by one what they cannot do together.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from followspot.errors import InputError
from followspot.graph.camera_kind import source_for
from followspot.room import Camera, Member, Room
from followspot.room_file import load
from followspot.tracking import DepthImage, Frame
from followspot_doctor.checks.source import TIMEOUT, tried
from followspot_doctor.finding import Finding, fine, wrong

MOST = 32
"""Cameras that are asked at once."""
_EXAMPLE = "source: {uses: cameras.video, with: {path: ...}}"


def cameras(path: str) -> Iterator[Finding]:
    """A finding a camera."""
    try:
        room = load(path)
    except InputError as error:
        for mistake in error.mistakes:
            yield wrong(f"room {mistake.place or path}", mistake.text, mistake.remedy)
        return
    with ThreadPoolExecutor(MOST) as pool:
        yield from pool.map(lambda camera: _camera(camera, room), room.cameras.values())


def _camera(camera: Camera, room: Room) -> Finding:
    found = tried(camera, room, lambda messages: next(messages, None), _EXAMPLE)
    if found.finding is not None or camera.source is None:
        return found.finding or wrong(camera.name, "has no source", _EXAMPLE)
    uses = source_for(camera.source.uses, Member("cameras", camera.name), room)
    if not isinstance(found.taken, Frame | DepthImage):
        text = f"{uses} gave no picture within {TIMEOUT:.0f} s: {found.said}"
        return wrong(camera.name, text, "is it connected, switched on, and free of other programs?")
    return _judged(camera, found.taken, uses)


def _judged(camera: Camera, frame: Frame | DepthImage, uses: str) -> Finding:
    picture = frame.depth if isinstance(frame, DepthImage) else frame.pixels
    height, width = picture.shape[:2]
    if (width, height) != camera.size:
        calibrated = "x".join(map(str, camera.size))
        text = f"sends {width}x{height}, calibrated for {calibrated}"
        return wrong(camera.name, text, "set its size, or calibrate it again at this one")
    if isinstance(frame, DepthImage):
        measured = f"{(picture > 0).mean():.0%} of the pixels measured"
        return fine(camera.name, f"{uses}: {width}x{height}, {measured}")
    if picture.shape[2] == 1 and camera.kind == "color":
        return wrong(camera.name, "sends grey pictures and is a colour camera", "kind: infrared?")
    return fine(camera.name, f"{uses}: {width}x{height}, mean grey {picture.mean():.0f}")

"""A waved bulb in recordings: the one bright spot of each picture, sub-pixel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot.messages import Array
from followspot_balls.templates.glowing_spot import brightness
from followspot_calibrate.adjust import Progress
from followspot_calibrate.clips import frames_of
from followspot_calibrate.planes.dots import dots
from followspot_calibrate.sightings import Sightings
from followspot_cameras.recordings import find_recordings

MOST_FRAMES = 100_000
"""Largest number of pictures of one recording."""
TOGETHER = 100
"""Pictures that give the room's look without the bulb, which moves meanwhile."""


def find_bulb(clips: Path, cameras: Sequence[Camera], progress: Progress | None = None) -> Sightings:
    """The bulb in CLIPS/<camera>.mkv, any video or a folder of pictures; equal numbers are equal moments.

    A picture in which a second spot is nearly as bright shows no bulb: which is the reflection is not clear.
    Raises InputError if a camera of the room has no recording.
    """
    recordings = find_recordings(clips, [camera.name for camera in cameras])
    absent = [camera.name for camera in cameras if camera.name not in recordings]
    if absent:
        text = f"{clips} has no recording of {', '.join(absent)}"
        raise InputError.of(text, f"needs {clips / absent[0]}.mkv, or a room without it")
    tracks = []
    for number, camera in enumerate(cameras):
        if progress is not None:
            progress(f"bulb in {camera.name}", number / len(cameras))
        tracks.append(_track(frames_of(recordings[camera.name], camera, MOST_FRAMES)))
    longest = max(map(len, tracks))
    pixel = np.full((longest, len(cameras), 2), np.nan)
    for number, track in enumerate(tracks):
        pixel[: len(track), number] = track
    names, sizes = tuple(c.name for c in cameras), np.array([c.size for c in cameras])
    return Sightings(names, sizes, np.arange(longest), np.zeros(longest, "i8"), pixel)


def _track(frames: Iterator[Array]) -> Array:
    """Image of the bulb in each picture, (F, 2) px, NaN if it is not seen."""
    places: list[Iterable[float]] = []
    while some := [brightness(pixels) for pixels in islice(frames, TOGETHER)]:
        places += [(np.nan, np.nan) if place is None else place for place in dots(some)]
    return np.array(places).reshape(-1, 2)

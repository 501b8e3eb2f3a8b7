"""Targets: recordings and pictures that are cut off, damaged or not what they say."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import cv2
import numpy as np

from followspot.context import Context
from followspot.errors import FollowspotError
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.room import Camera
from followspot_cameras.images import Images
from followspot_cameras.video.stage import Video
from fuzzing.mutation import broken_bytes
from fuzzing.target import Target

_SIZE = (64, 48)
_CODECS = (("mkv", "MJPG"), ("mkv", "FFV1"), ("mp4", "mp4v"), ("avi", "XVID"), ("webm", "VP80"))
_FRAMES = 8
_MOST_PLAYED = 1000
"""A damaged file that claims to go on for ever is left after so many pictures."""


def _camera() -> Camera:
    matrix = np.array([[60.0, 0, 32], [0, 60, 24], [0, 0, 1]])
    return Camera("cam0", "color", _SIZE, matrix, np.zeros(5), np.eye(3), np.zeros(3), "pinhole")


def _pictures() -> list[Any]:
    noise = np.random.default_rng(0)
    return [noise.integers(0, 255, (_SIZE[1], _SIZE[0], 3), np.uint8) for _ in range(_FRAMES)]


def _damaged(data: bytes, rng: random.Random) -> bytes:
    """Cut off, with noise in its head, or with bits flipped anywhere."""
    way = rng.random()
    if way < 0.2:
        return data[: rng.randrange(len(data))]
    if way < 0.5:
        head = rng.choice((100, 600, 2000))
        return broken_bytes(data[:head], rng) + data[head:]
    found = bytearray(data)
    for _ in range(rng.choice((1, 10, 100))):
        found[rng.randrange(len(found))] ^= 1 << rng.randrange(8)
    return bytes(found)


def _chosen(samples: Sequence[tuple[str, bytes]], rng: random.Random) -> tuple[str, bytes]:
    """The suffix and the damaged content of a sample."""
    suffix, data = rng.choice(samples)
    return suffix, _damaged(data, rng)


def _played(stage: Video | Images) -> int:
    """Play to the end as a worker does. Raises FollowspotError if not all pictures came."""
    count = 0
    try:
        stage.setup()
        stage.length()
        for _ in stage.process():
            count += 1
            if count >= _MOST_PLAYED:
                break
    finally:
        stage.close()
    if count < _FRAMES:
        raise FollowspotError(f"ended after {count} pictures")
    return count


def video_target() -> Target:
    """Video files of several containers and codecs."""
    folder = TemporaryFolder("fuzz")
    samples = []
    for suffix, codec in _CODECS:
        path = folder.path / f"whole.{suffix}"
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), 30.0, _SIZE)
        if not writer.isOpened():
            continue
        for picture in _pictures():
            writer.write(picture)
        writer.release()
        samples.append((suffix, path.read_bytes()))
    context = Context.serving(_camera(), name="camera/cam0")

    def take(made: tuple[str, bytes]) -> object:
        path = folder.path / f"broken.{made[0]}"
        path.write_bytes(made[1])
        return _played(Video(context, path=path))

    return Target(partial(_chosen, samples), take, (FollowspotError,))


def images_target() -> Target:
    """Folders with a damaged picture."""
    folder = TemporaryFolder("fuzz")
    samples = []
    for suffix in ("png", "jpg", "bmp", "tiff", "webp", "ppm"):
        _, data = cv2.imencode(f".{suffix}", _pictures()[0])
        samples.append((suffix, data.tobytes()))
    context = Context.serving(_camera(), name="camera/cam0")

    def take(made: tuple[str, bytes]) -> object:
        path = folder.path / f"frame.{made[0]}"
        path.write_bytes(made[1])
        warnings: list[str] = []
        stage = Images(replace(context, warn=warnings.append), path=folder.path)
        try:
            count = sum(1 for _ in _frames(stage))
        finally:
            path.unlink()
        if count == 0:
            raise FollowspotError(" ".join(warnings))
        return count

    return Target(partial(_chosen, samples), take, (FollowspotError,))


def _frames(stage: Images) -> Iterator[object]:
    stage.setup()
    yield from stage.process()
    stage.close()

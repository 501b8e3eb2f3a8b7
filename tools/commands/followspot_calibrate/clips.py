"""Clips of a room's cameras: a folder for each thing that is shown, in it a recording per camera."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from followspot import Camera, Context
from followspot.errors import InputError
from followspot.messages import Array
from followspot_cameras.images import Images
from followspot_cameras.video.stage import Video

MOST_FRAMES = 300
"""Frames read of a target's clip; more do not improve the template and fill the memory."""


def folders_of(folder: Path, noun: str) -> list[Path]:
    """The folders of the things shown, in the order of their names. Raises InputError if there is none."""
    found = sorted(p for p in folder.iterdir() if p.is_dir()) if folder.is_dir() else []
    if not found:
        raise InputError.of(f"{folder} has no folder per {noun}", f"needs {folder}/<{noun}>/<camera>.mkv")
    return found


def read_frames(recording: Path, camera: Camera, most: int) -> list[Array]:
    """The first pictures of a clip as the camera's frames, (H, W, channels) u8. Raises InputError."""
    return list(frames_of(recording, camera, most))


def frames_of(recording: Path, camera: Camera, most: int) -> Iterator[Array]:
    """The frames of a clip one by one, for clips that are too long to be held at once."""
    stage = (Images if recording.is_dir() else Video)(
        Context.serving(camera, name=str(recording)), path=recording, frames=most
    )
    stage.setup()
    try:
        for frame in stage.process():
            yield frame.pixels
    finally:
        stage.close()

"""Grey pictures of a camera: of a video, of a folder of pictures, or live."""

from __future__ import annotations

import sys
from collections.abc import Container, Iterator
from pathlib import Path

import cv2

from followspot import Camera, Context
from followspot.errors import InputError
from followspot.graph.parameters import path_parameters
from followspot.messages import Array
from followspot.plugins.registry import load_stage
from followspot.stage_params import PathIn
from followspot_cameras.images import read_picture
from followspot_cameras.picture_folder import SUFFIXES, natural_order
from followspot_cameras.recordings import SUFFIXES as VIDEOS
from followspot_cameras.recordings import find_recordings
from followspot_cameras.video.file import open_video

Numbered = Iterator[tuple[int, Array]]
"""Numbers of pictures and the pictures, (H, W) u8."""


def recordings(videos: Path | None, clips: list[str], cameras: list[str]) -> dict[str, Path]:
    """Camera -> recording: those of the folder with names of cameras, and CAMERA=PATH.

    cameras: only these; if empty, every recording of the folder is a camera. Raises InputError.
    """
    found: dict[str, Path] = {}
    given: dict[str, Path] = {}
    if videos is not None:
        found = find_recordings(videos, cameras or _names(videos))
    for clip in clips:
        name, _, path = clip.partition("=")
        if not path or not Path(path).exists():
            text = f"--clip {clip}: " + (f"{path} is not there" if path else "this is no CAMERA=PATH")
            raise InputError.of(text, "for example --clip cam0=boards/cam0.mp4")
        if name in given:
            text = f"--clip {clip}: {name} has another recording: {given[name]}"
            raise InputError.of(text, "give one for each camera; or put the pictures of both into one folder")
        given[name] = Path(path)
    found |= given
    if not found:
        text = f"{videos} has no recording of a camera" if videos else "no recordings are given"
        raise InputError.of(text, "give --videos DIR with DIR/<camera>.mp4, or --clip CAMERA=PATH")
    return found


def count(path: Path) -> int:
    """Number of pictures of a recording; of a video as its container says. Raises InputError."""
    if path.is_dir():
        return len(natural_order(path, "*"))
    capture = open_video(path)
    try:
        return max(0, int(capture.get(cv2.CAP_PROP_FRAME_COUNT)))
    finally:
        capture.release()


def pictures(path: Path, chosen: Container[int]) -> Numbered:
    """The chosen pictures of a video or a folder. Raises InputError if it is neither."""
    yield from _of_folder(path, chosen) if path.is_dir() else _of_video(path, chosen)


def live_pictures(camera: Camera) -> Numbered:
    """Pictures of the camera's own source as they come, without end; none if it gives none at first.

    Raises InputError.
    """
    use = camera.source
    stage_type = load_stage(use.uses) if use is not None else None
    if use is None or stage_type is None or not stage_type.live:
        text = f"camera {camera.name} has no live source"
        remedy = "give it one in the room file: source: {uses: cameras.device}, or give --videos"
        raise InputError.of(text, remedy)
    number = 0

    def warn(text: str) -> None:
        if not number:
            raise _Silent  # a person who holds a board there need not wait for it
        print(f"warning: {text}", file=sys.stderr)

    inside = use.params.keys() & set(path_parameters(stage_type.Params, PathIn))
    paths = {key: str(Path(use.folder) / str(use.params[key])) for key in inside}
    context = Context.serving(camera, name=camera.name, warn=warn)
    stage = stage_type(context, **{**use.params, **paths})
    stage.setup()
    try:
        for frame in stage.process():
            yield number, _gray(frame.pixels)
            number += 1
    except _Silent:
        return
    finally:
        stage.close()


class _Silent(Exception):
    """A live camera that gave no picture."""


def _names(folder: Path) -> list[str]:
    """Names of cameras that have a recording in a folder."""
    if not folder.is_dir():
        return []
    inside = sorted(folder.iterdir())
    return [
        p.stem if p.is_file() else p.name for p in inside if p.suffix.lower() in VIDEOS or _has_pictures(p)
    ]


def _has_pictures(path: Path) -> bool:
    return path.is_dir() and any(p.suffix.lower() in SUFFIXES for p in path.iterdir())


def _of_folder(path: Path, chosen: Container[int]) -> Numbered:
    for number, file in enumerate(natural_order(path, "*")):
        picture = read_picture(file, cv2.IMREAD_GRAYSCALE) if number in chosen else None
        if picture is not None:
            yield number, picture


def _of_video(path: Path, chosen: Container[int]) -> Numbered:
    capture = open_video(path)
    number = 0
    try:
        while capture.grab():
            if number in chosen:
                ok, picture = capture.retrieve()
                if ok:
                    yield number, _gray(picture)
            number += 1
    finally:
        capture.release()


def _gray(picture: Array) -> Array:
    if picture.ndim == 2 or picture.shape[2] == 1:
        return picture.reshape(picture.shape[:2])
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)

"""Copies of recorded rooms: encoded again, with noise added, or reversed in time."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from followspot import room_file
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot.room import Room, StageUse


@dataclass(frozen=True)
class Copy:
    """How a recording is changed. noise: sigma, grey levels; codec: four letters, of Matroska files."""

    reverse: bool
    noise: float
    codec: str

    @property
    def name(self) -> str:
        """Its name in tables."""
        return f"{'reversed' if self.reverse else 'forward'}, noise {self.noise:g}, {self.codec}"


def copied(source: Path, folder: Path, how: Copy) -> Path:
    """The room file of a copy in a folder.

    Raises FollowspotError unless the room's cameras and its truth are files.
    """
    room = room_file.load(source)
    cameras = {}
    for number, (name, camera) in enumerate(room.cameras.items()):
        path = folder / f"{name}.mkv"
        rng = np.random.default_rng(number)
        gray = camera.kind == "infrared"
        write_video(path, changed(pictures(file_of(camera.source, name)), how, gray, rng), how.codec)
        cameras[name] = replace(camera, source=StageUse("cameras.video", {"path": str(path)}))
    truth = folder / "truth.csv"
    write_truth(file_of(room.truth, "the truth"), truth, how.reverse)
    made: Room = replace(room, cameras=cameras, truth=StageUse("cameras.truth_csv", {"path": str(truth)}))
    room_file.save(made, folder / "room.yaml")
    return folder / "room.yaml"


def file_of(use: StageUse | None, whose: str) -> Path:
    """The file that a stage of a room reads. Raises FollowspotError if it reads none."""
    if use is None or "path" not in use.params:
        raise FollowspotError(f"{whose} is not read from a file, so it cannot be copied")
    return Path(use.folder, str(use.params["path"]))


def pictures(path: Path) -> tuple[list[Array], float]:
    """All pictures of a video, and how many follow in a second."""
    video = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    found: list[Array] = []
    while (read := video.read())[0]:
        found.append(read[1])
    rate = video.get(cv2.CAP_PROP_FPS)
    video.release()
    if not found:
        raise FollowspotError(f"{path} has no pictures")
    return found, rate


def changed(
    video: tuple[list[Array], float], how: Copy, gray: bool, rng: np.random.Generator
) -> tuple[Iterator[Array], float]:
    """The pictures of a copy; gray: whether all channels of a pixel get the same noise."""
    found, rate = video

    def noisy() -> Iterator[Array]:
        for picture in reversed(found) if how.reverse else found:
            shape = picture.shape[:2] + ((1,) if gray else picture.shape[2:])
            noise = rng.normal(0.0, how.noise, shape) if how.noise else np.zeros(shape)
            yield np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)

    return noisy(), rate


def write_video(path: Path, video: tuple[Iterator[Array], float], codec: str) -> None:
    """Encode pictures. Raises FollowspotError if OpenCV lacks the codec."""
    frames, rate = video
    first = next(frames)
    height, width = first.shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*codec), rate, (width, height))
    if not writer.isOpened():
        raise FollowspotError(f"OpenCV cannot write {codec}")
    for picture in (first, *frames):
        writer.write(picture)
    writer.release()


def write_truth(source: Path, path: Path, reverse: bool) -> None:
    """Copy a file of ground truth, frames and times reversed if wanted."""
    with source.open(newline="") as file:
        head, *rows = csv.reader(file)
    if reverse:
        rows = reversed_rows(rows, head.index("frame"), head.index("time"))
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


def reversed_rows(rows: Sequence[list[str]], frame: int, time: int) -> list[list[str]]:
    """Rows whose last frame comes first; frame, time: numbers of these columns."""
    last, end = max(int(row[frame]) for row in rows), max(float(row[time]) for row in rows)
    begin = min(float(row[time]) for row in rows)
    turned = []
    for row in rows:
        one = list(row)
        one[frame], one[time] = str(last - int(row[frame])), f"{begin + end - float(row[time]):.5f}"
        turned.append(one)
    return sorted(turned, key=lambda row: int(row[frame]))

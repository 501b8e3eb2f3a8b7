"""Pipes and endless devices in place of files: every reader refuses them and none waits or reads on."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import pytest

from followspot.csv_rows import read_rows
from followspot.errors import FollowspotError
from followspot.files import RUN_LOG
from followspot.log.file import read_log
from followspot.plugins.one_file import load_file
from followspot.room_file import load, update
from followspot.transport.host_registry import read_host_registry
from followspot_calibrate.board.timestamps import read_timestamps
from followspot_calibrate.points_file.reading import read_points
from followspot_cameras.images import read_picture
from followspot_cameras.video.file import open_video
from followspot_persons.body.shape import read_shape
from followspot_persons.color.difference import read_relations
from followspot_persons.hog.model import load as load_hog
from followspot_recording.recording import Recording
from followspot_room.calibration import read_calibration
from followspot_shape.crops import read_crops
from followspot_train.pictures import read_folder


def log(path: Path) -> object:
    path.rename(path.with_name(RUN_LOG))
    return list(read_log(path.parent))


def points(name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        return read_points(path.rename(path.with_name(name)), size=(320, 240))

    return read


def boxes(path: Path) -> None:
    path.rename(path.with_name("boxes.csv"))


def crops(path: Path) -> object:
    boxes(path)
    return read_crops(path.parent)


def pictures(path: Path) -> object:
    boxes(path)
    return read_folder(path.parent)


def matrix(path: Path) -> object:
    for name in ("points.dat", "Res.dat", "IdMat.dat"):
        path.with_name(name).symlink_to(path.name)
    return read_points(path.parent)


def picture(path: Path) -> object:
    if read_picture(path) is None:
        raise FollowspotError("no picture")
    return None


READERS: dict[str, Callable[[Path], object]] = {
    "rows": lambda path: list(read_rows(path, ("frame",))),
    "log": log,
    "plugin": lambda path: load_file(str(path.rename(path.with_name("odd.py")))),
    "room": load,
    "updated room": lambda path: update(path, planes={}),
    "registry": read_host_registry,
    "timestamps": lambda path: read_timestamps(path, ["cam0"]),
    "CSV points": points("points.csv"),
    "NPZ points": points("points.npz"),
    "matrices": matrix,
    "picture": picture,
    "video": open_video,
    "relations": read_relations,
    "detector": load_hog,
    "shape": read_shape,
    "recording": Recording,
    "calibration": read_calibration,
    "crops": crops,
    "pictures": pictures,
}


@pytest.fixture(autouse=True)
def _no_waiting() -> Iterator[None]:
    def stop(number: int, frame: FrameType | None) -> None:
        raise AssertionError("it waits, or reads without end")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


@pytest.mark.parametrize("make", [os.mkfifo, endless])
@pytest.mark.parametrize("reader", READERS)
def test_what_is_no_regular_file_is_refused(
    tmp_path: Path, reader: str, make: Callable[[Path], None]
) -> None:
    make(tmp_path / "odd")
    with pytest.raises(FollowspotError):
        READERS[reader](tmp_path / "odd")

"""A calibration as data, and the formats that it is read from, told apart by content."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from followspot.errors import InputError, Mistake
from followspot.messages import Array
from followspot.room import Camera
from followspot_room import opencv_json
from followspot_room.checks import Unfit

MOST_BYTES = 10_000_000


@dataclass(frozen=True, eq=False)
class Calibration:
    """Cameras and planes of a room; planes: name -> (4,) with unit normal, m; ball_radius: m, if known."""

    cameras: tuple[Camera, ...]
    planes: Mapping[str, Array] = field(default_factory=dict)
    ball_radius: float | None = None


@dataclass(frozen=True)
class Format:
    """A way to write calibrations: what users call it, and how it is parsed.

    parse: text -> the cameras, planes and ball radius, or None where the text is in another format;
    raises Unfit where it is this format with a mistake.
    """

    name: str
    parse: Callable[[str], Calibration | None]


def _opencv_json(text: str) -> Calibration | None:
    document = opencv_json.recognise(text)
    if document is None:
        return None
    return Calibration(
        opencv_json.cameras(document), opencv_json.planes(document), opencv_json.ball_radius(document)
    )


FORMATS = (Format('JSON with "cameras" that have K, dist, R and t (OpenCV convention)', _opencv_json),)
"""In the order in which they are tried."""


def read_calibration(path: Path) -> Calibration:
    """The calibration in a file of any known format. Raises InputError."""
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES + 1).decode("utf-8")
    except OSError as error:
        raise InputError([Mistake(None, f"{path} cannot be read: {error.strerror}")]) from None
    except UnicodeDecodeError:
        text = ""
    try:
        for known in FORMATS if len(text) <= MOST_BYTES else ():
            calibration = known.parse(text)
            if calibration is not None:
                return calibration
    except Unfit as mistake:
        raise InputError([Mistake(None, f"{path}: {mistake}")]) from None
    names = "; ".join(known.name for known in FORMATS)
    raise InputError([Mistake(None, f"{path} is no calibration in a known format", f"known: {names}")])

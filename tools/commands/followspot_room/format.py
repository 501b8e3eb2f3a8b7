"""A calibration as data, and the interface of a format of calibrations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from followspot.messages import Array
from followspot.room import Camera

Texts = Mapping[str, str]
"""Names of files -> their content: one file, or those of a folder."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Cameras and planes of a room; planes: name -> (4,) with unit normal, m; ball_radius: m, if known.

    notes: what the user should know of how it was read.
    """

    cameras: tuple[Camera, ...]
    planes: Mapping[str, Array] = field(default_factory=dict)
    ball_radius: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def posed(self) -> bool:
        """True if the poses are known: several cameras with one and the same pose have none."""
        poses = {(c.rotation.tobytes(), (c.translation + 0.0).tobytes()) for c in self.cameras}
        return len(poses) > 1 or len(self.cameras) < 2


@dataclass(frozen=True)
class Format:
    """A file format of calibrations.

    key: its name for `--format`; name: for users;
    parse: texts -> calibration, None if they are in another format; raises Unfit if they are in this one
    with a mistake; write: cameras -> texts, raises Unfit for a camera that the format cannot hold;
    folder: True for a folder of files, else one text of any name; infrared: whether what is written says
    which cameras are infrared.
    """

    key: str
    name: str
    parse: Callable[[Texts], Calibration | None]
    write: Callable[[Sequence[Camera]], Texts] | None = None
    folder: bool = False
    infrared: bool = False


def only_text(files: Texts) -> tuple[str, str] | None:
    """Name and text if there is a single file."""
    return next(iter(files.items())) if len(files) == 1 else None

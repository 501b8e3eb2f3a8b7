"""Views of a board from pictures, with the coverage on the terminal while they are found."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TextIO

from followspot.errors import InputError, Mistake
from followspot_calibrate.boards.detection import Detector, View
from followspot_calibrate.boards.pictures import Numbered
from followspot_calibrate.intrinsics.coverage import coverage

ENOUGH_VIEWS = 40
ENOUGH_COVERED = 0.9
"""Share of the picture at which a live camera has seen enough."""
MOVED = 0.01
"""Mean motion of the corners between two live views that both count, over the longer side of the picture."""


@dataclass(frozen=True, eq=False)
class Collected:
    """Views of one camera; size: of its pictures, px; looked_at: number of pictures."""

    views: tuple[View, ...]
    size: tuple[int, int]
    looked_at: int


def collect(
    camera: str, pictures: Numbered, total: int | None, detector: Detector, stream: TextIO = sys.stderr
) -> Collected:
    """The board in all pictures, of one size. total: how many will come; None for a live camera.

    A live camera ends when it has seen enough, or on Ctrl-C; views without motion count once then.
    Raises InputError if the size changes.
    """
    views: list[View] = []
    size, looked_at = (0, 0), 0
    display = Display(camera, stream)
    try:
        for number, gray in pictures:
            if looked_at and gray.shape[::-1] != size:
                raise InputError([_other_size(camera, number, gray.shape[::-1], size)])
            size, looked_at = (gray.shape[1], gray.shape[0]), looked_at + 1
            view = detector.find(gray, number)
            if view is not None and (total is not None or _is_new(view, views, size)):
                views.append(view)
            display.show(views, size, looked_at, total)
            if total is None and _is_enough(views, size):
                break
    except KeyboardInterrupt:
        if total is not None:
            raise
    finally:
        display.close()
    return Collected(tuple(views), size, looked_at)


class Display:
    """Coverage and progress on a terminal, drawn over itself; nothing elsewhere."""

    def __init__(self, camera: str, stream: TextIO) -> None:
        self.camera = camera
        self.stream = stream
        self.lines = 0

    def show(self, views: list[View], size: tuple[int, int], looked_at: int, total: int | None) -> None:
        """Draw the present state."""
        if not self.stream.isatty():
            return
        covered = coverage(views, size)
        hint = f"still missing: {', '.join(covered.missing)}" if covered.missing else "all parts are covered"
        of = f" of {total}" if total else ""
        head = f"{self.camera}: {len(views)} views in {looked_at}{of} pictures"
        lines = [head, *covered.drawing(), hint]
        self._back()
        self.stream.write("".join(f"\x1b[K{line}\n" for line in lines))
        self.stream.flush()
        self.lines = len(lines)

    def close(self) -> None:
        """Wipe the drawing."""
        self._back()
        if self.lines:
            self.stream.write("\x1b[J")
            self.stream.flush()

    def _back(self) -> None:
        if self.lines:
            self.stream.write(f"\x1b[{self.lines}A")


def _other_size(camera: str, number: int, found: tuple[int, ...], size: tuple[int, int]) -> Mistake:
    text = f"{camera}: picture {number} is {found[0]}x{found[1]} px, those before it {size[0]}x{size[1]}"
    return Mistake(None, text, "give pictures of one size; a lens is calibrated for one")


def _is_new(view: View, views: list[View], size: tuple[int, int]) -> bool:
    """True if the board has moved since the last counted view."""
    if not views or len(views[-1].label) != len(view.label) or (views[-1].label != view.label).any():
        return True
    return bool(abs(view.pixel - views[-1].pixel).mean() > MOVED * max(size))


def _is_enough(views: list[View], size: tuple[int, int]) -> bool:
    return len(views) >= ENOUGH_VIEWS and coverage(views, size).share >= ENOUGH_COVERED

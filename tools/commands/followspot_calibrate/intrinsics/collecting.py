"""Views of a board from pictures, with the coverage on the terminal while they are found."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TextIO

from rich.live import Live

from followspot.errors import InputError, Mistake
from followspot.tables.terminal import literal_console
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
    console = literal_console(file=stream)
    try:
        with Live(console=console, transient=True, auto_refresh=False) as drawing:
            for number, gray in pictures:
                if looked_at and gray.shape[::-1] != size:
                    raise InputError([_other_size(camera, number, gray.shape[::-1], size)])
                size, looked_at = (gray.shape[1], gray.shape[0]), looked_at + 1
                view = detector.find(gray, number)
                if view is not None and (total is not None or _is_new(view, views, size)):
                    views.append(view)
                if console.is_terminal:
                    drawing.update(_drawn(camera, views, size, looked_at, total), refresh=True)
                if total is None and _is_enough(views, size):
                    break
    except KeyboardInterrupt:
        if total is not None:
            raise
    return Collected(tuple(views), size, looked_at)


def _drawn(camera: str, views: list[View], size: tuple[int, int], looked_at: int, total: int | None) -> str:
    """The present state for a terminal."""
    covered = coverage(views, size)
    hint = f"still missing: {', '.join(covered.missing)}" if covered.missing else "all parts are covered"
    of = f" of {total}" if total else ""
    head = f"{camera}: {len(views)} views in {looked_at}{of} pictures"
    return "\n".join([head, *covered.drawing(), hint])


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

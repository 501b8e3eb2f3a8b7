"""Which part of a camera's picture has seen corners, and which still lacks them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_calibrate.boards.detection import View

COLUMNS, ROWS = 8, 6
SHADES = " .:*#"
"""For 0, few, some, many and most corners in a cell."""
MANY = 30
"""Corners in a cell that is drawn as full."""
PARTS = (("upper", "middle", "lower"), ("left", "centre", "right"))


@dataclass(frozen=True, eq=False)
class Coverage:
    """Corners seen in each cell of the picture: count (ROWS, COLUMNS)."""

    count: Array

    @property
    def share(self) -> float:
        """Share of the cells with at least one corner, 0 to 1."""
        return float((self.count > 0).mean())

    @property
    def missing(self) -> list[str]:
        """The ninths of the picture of which most has no corner: "upper left", ..."""
        rows = np.array_split(np.arange(ROWS), 3)
        columns = np.array_split(np.arange(COLUMNS), 3)
        return [
            f"{up} {side}".replace("middle centre", "middle")
            for up, r in zip(PARTS[0], rows, strict=True)
            for side, c in zip(PARTS[1], columns, strict=True)
            if (self.count[np.ix_(r, c)] > 0).mean() < 0.5
        ]

    def drawing(self) -> list[str]:
        """The picture as lines of text: the darker a cell, the more corners it has."""
        level = np.ceil(np.minimum(self.count / MANY, 1.0) * (len(SHADES) - 1)).astype(int)
        edge = "+" + "--" * COLUMNS + "+"
        return [edge, *("|" + "".join(SHADES[i] * 2 for i in row) + "|" for row in level), edge]


def coverage(views: Iterable[View], size: tuple[int, int]) -> Coverage:
    """Coverage of a picture of this size, px, by these views."""
    pixel = np.concatenate([np.empty((0, 2)), *(view.pixel for view in views)])
    cell = (pixel / size * [COLUMNS, ROWS]).astype(int).clip(0, [COLUMNS - 1, ROWS - 1])
    return Coverage(
        np.bincount(cell[:, 1] * COLUMNS + cell[:, 0], minlength=COLUMNS * ROWS).reshape(ROWS, COLUMNS)
    )

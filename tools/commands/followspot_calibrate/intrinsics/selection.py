"""Which views are worth calibrating from: sharp ones, that differ from each other in place, size and tilt."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from followspot.messages import Array
from followspot_calibrate.boards.board import Board
from followspot_calibrate.boards.detection import View

MOST_VIEWS = 40
"""More make the fit slow and no better."""
BLURRED = 2.5
"""Width of edges over that of the sharpest quarter, from which a view counts as blurred..."""
SHARP_ENOUGH = 4.0
"""... unless its edges are narrower than this, px."""


def sharp(views: Sequence[View]) -> list[View]:
    """The views that are not blurred, in their order."""
    if not views:
        return []
    quarter = float(np.percentile([view.blur for view in views], 25))
    return [view for view in views if view.blur <= max(BLURRED * quarter, SHARP_ENOUGH)]


def diverse(views: Sequence[View], board: Board, size: tuple[int, int], most: int = MOST_VIEWS) -> list[View]:
    """At most this many views, each as different from the others as possible; the first has most corners.

    The distance is that of :func:`appearance`. size: of the picture, px.
    """
    if len(views) <= most:
        return list(views)
    looks = np.array([appearance(view, board, size) for view in views])
    chosen = [int(np.argmax([len(view.label) for view in views]))]
    apart = np.linalg.norm(looks - looks[chosen[0]], axis=1)
    while len(chosen) < most:
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.linalg.norm(looks - looks[chosen[-1]], axis=1))
    return [views[i] for i in sorted(chosen)]


def appearance(view: View, board: Board, size: tuple[int, int]) -> Array:
    """Place, size and tilt of a board in a picture: (6,), each from about -1 to 1.

    Centre over half the picture; logarithm of the size; tilt as the change of scale across the board (the
    last row of its homography); the rotation about the line of sight enters with its cosine.
    """
    corners = board.corners[view.label, :2]
    corners = (corners - board.corners[:, :2].mean(axis=0)) / np.ptp(board.corners[:, :2], axis=0).max()
    pixel = (view.pixel - np.array(size) / 2) / (max(size) / 2)
    H, _ = cv2.findHomography(corners, pixel)
    across = H[:2, 0] - H[2, 0] * H[:2, 2]
    scale = np.sqrt(abs(np.linalg.det(H[:2, :2] - np.outer(H[:2, 2], H[2, :2]))))
    return np.array([*H[:2, 2], np.log(max(scale, 1e-3)), *(2 * H[2, :2]), across[0] / np.hypot(*across)])

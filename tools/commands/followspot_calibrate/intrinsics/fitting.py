"""Fit of a lens to views of a board, pinhole or fisheye, with the uncertainty of what it found."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.boards.board import Board
from followspot_calibrate.boards.detection import View

Lens = Literal["pinhole", "fisheye"]
LEAST_VIEWS = 3
SURE = 5.0
"""A k3 smaller than so many of its sigmas is noise and is left out."""
STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-10)
_ILL = re.compile(r"input array (\d+)")


@dataclass(frozen=True, eq=False)
class Fit:
    """A lens and the board's pose in each view.

    matrix: (3, 3) px; distortion: (5,) or (4,); rotation: (V, 3, 3) and translation: (V, 3) m of the board
    in camera coordinates; residual: per view (K, 2) px, seen minus expected;
    sigma: (4 + n,) of fx, fy, cx, cy (px) and the n coefficients that were free.
    """

    views: tuple[View, ...]
    matrix: Array
    distortion: Array
    rotation: Array
    translation: Array
    residual: tuple[Array, ...]
    sigma: Array

    @property
    def per_view(self) -> Array:
        """Root mean square error of each view, (V,) px."""
        return np.array([np.sqrt(np.square(r).sum(axis=1).mean()) for r in self.residual])

    @property
    def rms(self) -> float:
        """Root mean square error of all corners, px."""
        return float(np.sqrt(np.square(np.concatenate(self.residual)).sum(axis=1).mean()))


class NoFit(FollowspotError):
    """The views determine no lens."""


def fit(views: Sequence[View], board: Board, size: tuple[int, int], model: Lens) -> Fit:
    """The lens that explains the views best (Zhang 2000; Kannala & Brandt 2006). Raises NoFit.

    size: of the picture, px. A fisheye view that determines no pose is left out.
    """
    if len(views) < LEAST_VIEWS:
        raise NoFit(f"{len(views)} usable views of the board, at least {LEAST_VIEWS} are needed")
    if model == "fisheye":
        return _fisheye(list(views), board, size)
    found = _pinhole(views, board, size, 0)
    k3, sigma = found.distortion[4], found.sigma[8]
    return found if abs(k3) > SURE * sigma else _pinhole(views, board, size, cv2.CALIB_FIX_K3)


def _pinhole(views: Sequence[View], board: Board, size: tuple[int, int], flags: int) -> Fit:
    objects = [board.corners[v.label].astype(np.float32)[:, None] for v in views]
    pixels = [v.pixel.astype(np.float32)[:, None] for v in views]
    start = np.zeros((3, 3))
    try:
        _, K, lens, turns, shifts = cv2.calibrateCamera(
            objects, pixels, size, start, np.zeros(5), flags=flags, criteria=STOP
        )
    except cv2.error as error:
        raise NoFit(f"no lens explains the views: {error.err}") from None
    free = 8 if flags & cv2.CALIB_FIX_K3 else 9
    return _finished(views, board, K, lens.ravel()[:5], turns, shifts, free)


def _fisheye(views: list[View], board: Board, size: tuple[int, int]) -> Fit:
    """OpenCV gives up for one view that determines no pose, and seldom names the right one."""
    while len(views) >= LEAST_VIEWS:
        try:
            return _fisheye_of(views, board, size)
        except cv2.error as error:
            named = _ILL.search(str(error))
        for number in range(len(views) if len(views) > LEAST_VIEWS else 0):
            try:
                return _fisheye_of([*views[:number], *views[number + 1 :]], board, size)
            except cv2.error:
                continue
        views.pop(int(named[1]) if named else -1)
    raise NoFit("no fisheye lens explains the views; show the board nearer, in all parts of the picture")


def _fisheye_of(views: Sequence[View], board: Board, size: tuple[int, int]) -> Fit:
    """Raises cv2.error."""
    flags = cv2.fisheye.CALIB_RECOMPUTE_EXTRINSIC | cv2.fisheye.CALIB_FIX_SKEW | cv2.fisheye.CALIB_CHECK_COND
    objects = [board.corners[v.label][:, None] for v in views]
    pixels = [v.pixel[:, None] for v in views]
    _, K, lens, turns, shifts = cv2.fisheye.calibrate(
        objects, pixels, size, np.zeros((3, 3)), np.zeros((4, 1)), flags=flags, criteria=STOP
    )
    return _finished(views, board, K, lens.ravel(), turns, shifts, 8)


def _finished(
    views: Sequence[View],
    board: Board,
    K: Array,
    lens: Array,
    turns: Sequence[Array],
    shifts: Sequence[Array],
    free: int,
) -> Fit:
    """The fit with residuals and the uncertainty of its first `free` intrinsic parameters."""
    project = _project_fisheye if len(lens) == 4 else _project_pinhole
    normal = np.zeros((free, free))
    residual = []
    for view, turn, shift in zip(views, turns, shifts, strict=True):
        pixel, inner, outer = project(board.corners[view.label], turn, shift, K, lens)
        residual.append(view.pixel - pixel)
        A, B = inner[:, :free], outer
        normal += A.T @ (A - B @ np.linalg.lstsq(B, A, rcond=None)[0])
    count = 2 * sum(map(len, residual)) - free - 6 * len(views)
    variance = np.square(np.concatenate(residual)).sum() / max(count, 1)
    return Fit(
        tuple(views),
        K,
        lens,
        np.array([cv2.Rodrigues(turn)[0] for turn in turns]),
        np.reshape(shifts, (-1, 3)),
        tuple(residual),
        np.sqrt(np.maximum(variance * np.diag(np.linalg.pinv(normal, hermitian=True)), 0.0)),
    )


def _project_pinhole(
    points: Array, turn: Array, shift: Array, K: Array, lens: Array
) -> tuple[Array, Array, Array]:
    """Images, and their derivatives by fx fy cx cy k1 k2 p1 p2 k3 and by the pose."""
    pixel, J = cv2.projectPoints(points, turn, shift, K, lens)
    return pixel.reshape(-1, 2), J[:, 6:15], J[:, :6]


def _project_fisheye(
    points: Array, turn: Array, shift: Array, K: Array, lens: Array
) -> tuple[Array, Array, Array]:
    """Project through a fisheye lens, by fx fy cx cy k1 k2 k3 k4."""
    pixel, J = cv2.fisheye.projectPoints(points[:, None], turn, shift, K, lens)
    return pixel.reshape(-1, 2), J[:, :8], J[:, 8:14]

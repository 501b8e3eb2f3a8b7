"""Corners of a board in a picture, to a fraction of a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.boards.board import Board
from followspot_vision.edge_corners import edge_corners

AROUND = [0, 1, 3, 2]
"""Labels of a marker's corners, row by row, in the order around it in which they are found."""
SEARCHED = 1000
"""Longer side of the picture in which a chessboard is searched, px; corners are refined in the full one."""
WINDOW = 0.35
"""Half the window of refinement over the distance of two corners."""
LARGEST_WINDOW = 11
"""px"""
REFINED = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-3)
PATCH = 0.4
"""Half the side of the patch around a corner in which its edge is measured, over the distance of corners."""

DIRECTIONS = np.array([[np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 6])


@dataclass(frozen=True, eq=False)
class View:
    """A board in one picture.

    frame: number of the picture; label: (K,) int64, which corners; pixel: (K, 2) px;
    blur: width of the edges, px: 1 to 3 if they are sharp.
    """

    frame: int
    label: Array
    pixel: Array
    blur: float


class Detector:
    """Finds one kind of board in pictures."""

    def __init__(self, board: Board, camera: Camera | None = None) -> None:
        """camera: with a lens that is known, by which the sides of a single marker are straight."""
        self.board, self.camera = board, camera
        self.markers = _marker_detector(board) if board.pattern == "aruco" else None
        self.charuco = _charuco_detector(board) if board.pattern == "charuco" else None

    def find(self, gray: Array, frame: int = 0) -> View | None:
        """The board's corners in a picture, (H, W) u8; None if too few are seen."""
        if self.markers is not None:
            found = self._marker(self.markers, gray)
        else:
            found = self._charuco(gray) if self.charuco is not None else self._chessboard(gray)
        if found is None:
            return None
        label, pixel = found
        column = label % self.board.inner[0]
        if len(label) < self.board.fewest or np.ptp(column) == 0 or np.ptp(label - column) == 0:
            return None
        return View(frame, label, pixel, edge_width(gray, pixel, corner_distance(pixel)))

    def _marker(self, detector: cv2.aruco.ArucoDetector, gray: Array) -> tuple[Array, Array] | None:
        """The corners of the single marker; None if it is seen twice, for one of them is another's."""
        positive = 255 - gray if self.board.inverted else gray
        corners, ids, _ = detector.detectMarkers(positive)
        same = [] if ids is None else np.flatnonzero(ids.ravel() == self.board.number).tolist()
        if len(same) != 1:
            return None
        pixel = corners[same[0]].reshape(4, 2).astype(np.float64)
        if self.camera is not None:
            pixel = edge_corners(self.camera, positive, pixel)
        return np.arange(4), pixel[AROUND]

    def _charuco(self, gray: Array) -> tuple[Array, Array] | None:
        assert self.charuco is not None
        corners, ids, _, _ = self.charuco.detectBoard(255 - gray if self.board.inverted else gray)
        if ids is None or len(ids) == 0:
            return None
        return ids.ravel().astype(np.int64), corners.reshape(-1, 2).astype(np.float64)

    def _chessboard(self, gray: Array) -> tuple[Array, Array] | None:
        """All corners or none, because single corners of this pattern have no identity."""
        shrink = min(1.0, SEARCHED / max(gray.shape))
        small = cv2.resize(gray, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
        flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
        found, corners = cv2.findChessboardCornersSB(small, self.board.inner, flags=flags)
        if not found:
            return None
        pixel = (corners.reshape(-1, 2).astype(np.float64) + 0.5) / shrink - 0.5
        half = int(np.clip(WINDOW * corner_distance(pixel), 2, LARGEST_WINDOW))
        start = pixel.astype(np.float32).reshape(-1, 1, 2)
        refined = cv2.cornerSubPix(gray, start, (half, half), (-1, -1), REFINED)
        pixel = np.asarray(refined, np.float64).reshape(-1, 2)
        return np.arange(len(pixel)), pixel if _begins_dark(gray, pixel, self.board) else pixel[::-1]


def corner_distance(pixel: Array) -> float:
    """Distance of neighbouring corners: the median distance to the nearest other one, px."""
    apart = np.linalg.norm(pixel[:, None] - pixel[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    return float(np.median(apart.min(axis=1)))


def edge_width(gray: Array, pixel: Array, distance: float) -> float:
    """Median over the corners of contrast over steepest slope in the worst direction, px.

    Motion blurs the edges across it only, hence the direction; defocus blurs all.
    gray: (H, W) u8; distance: of neighbouring corners, px. Infinite if no corner has a whole patch.
    """
    half = max(3, round(PATCH * distance))
    widths = []
    for x, y in np.rint(pixel).astype(int):
        patch = gray[max(0, y - half) : y + half + 1, max(0, x - half) : x + half + 1].astype(np.float32)
        if min(patch.shape) < 2 * half + 1:
            continue
        dy, dx = np.gradient(patch)
        low, high = np.percentile(patch, (10, 90))
        slope = np.abs(np.tensordot(DIRECTIONS, [dx, dy], axes=1)).max(axis=(1, 2)).min()
        widths.append((high - low) / max(float(slope), 1e-6))
    return float(np.median(widths)) if widths else float("inf")


def _begins_dark(gray: Array, pixel: Array, board: Board) -> bool:
    """True if the square beside the first corner is darker than the one beside it.

    That decides which end of a chessboard is its beginning, unless the board is symmetric.
    """
    across, down = board.inner
    grid = pixel.reshape(down, across, 2)
    centers = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
    x, y = np.rint(centers).astype(int).T
    brightness = gray[np.clip(y.T, 0, gray.shape[0] - 1), np.clip(x.T, 0, gray.shape[1] - 1)].astype(float)
    dark = np.add.outer(np.arange(down - 1), np.arange(across - 1)) % 2 == 0
    return bool(brightness[dark].mean() < brightness[~dark].mean())


def _marker_detector(board: Board) -> cv2.aruco.ArucoDetector:
    asked = cv2.aruco.DetectorParameters()
    asked.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    return cv2.aruco.ArucoDetector(dictionary, asked)


def _charuco_detector(board: Board) -> cv2.aruco.CharucoDetector:
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    pattern = cv2.aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary)
    pattern.setLegacyPattern(board.legacy)
    return cv2.aruco.CharucoDetector(pattern)

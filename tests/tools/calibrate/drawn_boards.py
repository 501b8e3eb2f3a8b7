"""Pictures of boards as known cameras would take them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from followspot.geometry import ray
from followspot.messages import Array
from followspot.room import Camera
from followspot_calibrate.boards.board import Board

SQUARE = 40
"""px of the drawing."""
MARGIN = 1
"""White border around the pattern, squares."""


def lens(model: str = "pinhole", **changes: object) -> Camera:
    """A camera at the origin that looks along z."""
    fields: dict[str, object] = {
        "name": "cam0",
        "kind": "color",
        "size": (640, 480),
        "matrix": np.array([[520.0, 0.0, 325.0], [0.0, 523.0, 236.0], [0.0, 0.0, 1.0]]),
        "distortion": np.array([-0.18, 0.06, 0.001, -0.0005, 0.0]),
        "rotation": np.eye(3),
        "translation": np.zeros(3),
        "model": model,
    }
    if model == "fisheye":
        fields["matrix"] = np.array([[230.0, 0.0, 322.0], [0.0, 231.0, 243.0], [0.0, 0.0, 1.0]])
        fields["distortion"] = np.array([0.05, -0.01, 0.004, -0.001])
    return Camera(**{**fields, **changes})  # type: ignore[arg-type]


@dataclass(frozen=True)
class Place:
    """Where a board is: tilt (Rodrigues vector, rad) and its middle in the camera's coordinates, m."""

    tilt: tuple[float, float, float]
    middle: tuple[float, float, float]


def drawing(board: Board) -> Array:
    """The printed board, with a white border, (H, W) u8."""
    if board.pattern == "charuco":
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
        pattern = cv2.aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary)
        picture = pattern.generateImage((board.columns * SQUARE, board.rows * SQUARE))
    elif board.pattern == "aruco":
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
        picture = cv2.aruco.generateImageMarker(dictionary, board.number, 3 * SQUARE)
    else:
        row, column = np.indices((board.rows + 1, board.columns + 1))
        picture = np.kron((row + column) % 2 * 255, np.ones((SQUARE, SQUARE))).astype("u1")
    picture = cv2.copyMakeBorder(picture, *[MARGIN * SQUARE] * 4, cv2.BORDER_CONSTANT, value=255)
    return 255 - picture if board.inverted else picture


class Photographer:
    """Takes pictures of boards with one camera, whose rays are computed once."""

    def __init__(self, camera: Camera, board: Board) -> None:
        self.board = board
        self.size = camera.size
        width, height = camera.size
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        still = replace(camera, rotation=np.eye(3), translation=np.zeros(3))
        self.rays = ray(still, np.column_stack([x.ravel(), y.ravel()]).astype(float))
        self.drawing = drawing(board)

    def picture(self, place: Place) -> Array:
        """What the camera sees, (H, W) u8: each pixel's ray meets the board's plane."""
        R = cv2.Rodrigues(np.array(place.tilt))[0]
        t = np.array(place.middle) - R @ self.board.corners.mean(axis=0)
        depth = (R[:, 2] @ t) / (self.rays @ R[:, 2])
        local = (self.rays * depth[:, None] - t) @ R
        if self.board.pattern == "aruco":
            first, square = MARGIN, self.board.square / 3
        else:
            first, square = MARGIN + 1, self.board.square  # one square before the first inner corner
        where = ((local[:, :2] / square + first) * SQUARE - 0.5).astype(np.float32)
        where[depth <= 0] = -1e4
        shape = (self.size[1], self.size[0])
        u, v = where[:, 0].reshape(shape), where[:, 1].reshape(shape)
        seen = cv2.remap(
            self.drawing, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=128
        )
        return cv2.GaussianBlur(seen, (0, 0), 0.8)

    def corners(self, place: Place) -> Array:
        """The board's corners in the camera's coordinates, (N, 3) m."""
        R = cv2.Rodrigues(np.array(place.tilt))[0]
        middle = self.board.corners.mean(axis=0)
        return (self.board.corners - middle) @ R.T + np.array(place.middle)


def places(near: float, spread: tuple[float, float], count: int = 12, tilt: float = 0.6) -> list[Place]:
    """Boards all over the picture, tilted to all sides by up to this angle, rad.

    near: m; spread: of the middle over its distance, across and down.
    """
    found = []
    for i in range(count):
        around = 2.4 * i
        reach = 0.35 + 0.65 * ((i * 5) % count) / count
        distance = near * (1 + 0.5 * (i % 3) / 2)
        x, y = reach * np.cos(around) * spread[0], reach * np.sin(around) * spread[1]
        lean = tilt * np.array([np.sin(1.7 * i), np.cos(2.3 * i), 0.3 * np.sin(i)])
        found.append(Place(tuple(lean), (x * distance, y * distance, distance)))
    return found

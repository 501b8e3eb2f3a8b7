"""Square markers in pictures: the ArUco and AprilTag dictionaries of OpenCV."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import cv2
import numpy as np

from followspot import Array, Field, Mistake, Room, Stage, StageParams
from followspot.geometry import undistort
from followspot.room import Member
from followspot.tracking import Frame
from followspot_vision.edge_corners import edge_corners
from followspot_vision.marker_messages import Markers

Dictionary = Literal[
    "DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250", "DICT_4X4_1000",
    "DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250", "DICT_5X5_1000",
    "DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250", "DICT_6X6_1000",
    "DICT_7X7_50", "DICT_7X7_100", "DICT_7X7_250", "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_ARUCO_MIP_36h12",
    "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10", "DICT_APRILTAG_36h11",
]  # fmt: skip
SMALLEST = 16
"""Shortest side of a picture in which markers are looked for, px."""


class Aruco(Stage):
    """Find ArUco markers or AprilTags in a picture; of several with the same name, only the largest."""

    per_camera = True

    class Params(StageParams):
        dictionary: Dictionary = Field("DICT_4X4_50", description="the markers that are printed")
        ids: list[int] = Field(
            [], description="numbers of the markers to find; empty: all; fewer avoid mistakes"
        )
        names: dict[int, str] = Field({}, description="names of markers by number, instead of their numbers")
        refinement: Literal["edges", "subpixel", "none"] = Field(
            "edges",
            description="how corners are refined: as intersections of the sides, each in its own "
            "surroundings, which is rougher and pulls them inwards, or not at all",
        )
        minimum_perimeter: float = Field(
            0.03,
            gt=0,
            le=4,
            unit="1",
            description="smallest perimeter over the longer side of the picture; lowering it finds more "
            "distant markers and costs time",
        )

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Numbers of markers that the dictionary has not: they would never be found."""
        last = len(_dictionary(params.dictionary).bytesList) - 1
        for key, numbers in (("ids", params.ids), ("names", params.names)):
            strange = [number for number in numbers if not 0 <= number <= last]
            if strange:
                text = f"{key}: {params.dictionary} has no marker {strange[0]}"
                yield Mistake(None, text, f"its markers are 0 to {last}")

    def setup(self) -> None:
        p = self.params
        asked = cv2.aruco.DetectorParameters()
        if p.refinement == "subpixel":
            asked.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        asked.minMarkerPerimeterRate = p.minimum_perimeter
        self.detector = cv2.aruco.ArucoDetector(_dictionary(p.dictionary), asked)

    def process(self, frame: Frame) -> Markers:
        ids, corners = self.found(frame.pixels)
        texts = [self.params.names.get(number, str(number)) for number in ids.tolist()]
        names = tuple(dict.fromkeys(texts))
        largest = _largest_of_each([names.index(text) for text in texts], corners)
        pixel = corners[largest]
        return Markers(
            camera=self.camera.name,
            names=names,
            marker=np.arange(len(names), dtype=np.int32),
            id=ids[largest],
            pixel=pixel,
            xy=undistort(self.camera, pixel.reshape(-1, 2)).reshape(-1, 4, 2),
        )

    def found(self, pixels: Array) -> tuple[Array, Array]:
        """Numbers, (N,), and corners, (N, 4, 2) px, of the markers that are asked for."""
        if min(pixels.shape[:2]) < SMALLEST:
            return np.empty(0, np.int32), np.empty((0, 4, 2))
        gray = pixels[..., 0] if pixels.shape[2] == 1 else cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
        corners, ids, _ = self.detector.detectMarkers(gray)
        if not len(corners):
            return np.empty(0, np.int32), np.empty((0, 4, 2))
        number, corner = np.reshape(ids, -1).astype(np.int32), np.reshape(corners, (-1, 4, 2)).astype(float)
        rows = np.isin(number, self.params.ids) if self.params.ids else np.ones(len(number), bool)
        rows = np.flatnonzero(rows)
        order = rows[np.lexsort((corner[rows, 0, 0], number[rows]))]
        if self.params.refinement == "edges":
            for row in order.tolist():
                corner[row] = edge_corners(self.camera, gray, corner[row])
        return number[order], corner[order]


def _dictionary(name: Dictionary) -> cv2.aruco.Dictionary:
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


def _largest_of_each(names: list[int], corners: Array) -> Array:
    """The row of each name, ascending from 0, whose outline is longest. corners: (N, 4, 2) px."""
    outline = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).sum(axis=1)
    order = np.lexsort((-outline, names))
    first = np.unique(np.array(names, int)[order], return_index=True)[1]
    return np.asarray(order[first])

"""From views of a board in all cameras to camera poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Free, adjust
from followspot_calibrate.board.chain import Pairs, chained, relations
from followspot_calibrate.board.exchanged import exchange_that_helps, require_own_lenses
from followspot_calibrate.board.poses import board_poses
from followspot_calibrate.board.rigidity import Distances, distances
from followspot_calibrate.board.sighting import sightings_of
from followspot_calibrate.boards.board import Board
from followspot_calibrate.boards.detection import View
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.similarity import Similarity, on_a_line, similarity
from followspot_calibrate.triangulation import triangulate

ROUNDS = 2
"""Rounds of adjusting and rejecting."""
OUTLIER = 8.0
"""Reprojection error over its median from which a sighting is rejected..."""
LEAST_OUTLIER = 1.0
"""... unless it is smaller than this, px."""
MOST_REJECTED = 0.5
"""Share of a camera's sightings beyond which the others do not see the same board."""
FLOOR = np.diag([1.0, -1.0, -1.0])
"""From the board's frame, y down and z into the board, to a room with the board as floor, z up."""

Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class BoardCalibration:
    """The camera poses, and how well they explain the sightings.

    sightings: of corners that at least two cameras saw; points: (N, 3) m; residual: (N, C) px, NaN if not
    seen or rejected; rejected: (C,) sightings that contradict the others; pairs: of cameras that saw the
    board together; distances: between corners of the board, measured against printed; scale: ratio of
    lengths from the lenses alone to the board's.
    """

    cameras: tuple[Camera, ...]
    sightings: Sightings
    points: Array
    residual: Array
    rejected: Array
    pairs: Pairs
    distances: Distances
    scale: float

    @property
    def rms(self) -> Array:
        """Root mean square error of each camera, (C,) px."""
        return np.asarray(np.sqrt(np.nanmean(np.square(self.residual), axis=0)))


def solve(
    cameras: Sequence[Camera],
    views: Mapping[str, Sequence[View]],
    board: Board,
    floor: int | None = None,
    progress: Progress | None = None,
) -> BoardCalibration:
    """Poses, m, of all cameras with known lenses.

    views: camera -> its views, where frame is the number of the moment; floor: the moment at which the board
    lies on the floor; without one the first camera keeps its pose. Raises FollowspotError.
    """
    pairs, placed = _started(cameras, views, board)
    seen = sightings_of(cameras, views)
    seen = seen.rows(seen.seen.sum(axis=1) >= 2)
    pixel = seen.pixel.copy()
    points = triangulate(placed, pixel).points
    residual = np.full(pixel.shape[:2], np.nan)
    for _ in range(ROUNDS):
        found = adjust(placed, points, pixel, Free(), progress=progress)
        placed, points, residual = found.cameras, found.points, found.residual
        limit = max(OUTLIER * float(np.nanmedian(residual)), LEAST_OUTLIER)
        pixel[~(residual < limit)] = np.nan
    require_own_lenses(placed, points, pixel, residual)
    lonely = np.isfinite(pixel[..., 0]).sum(axis=1) < 2
    points[lonely], pixel[lonely] = np.nan, np.nan
    residual[np.isnan(pixel[..., 0])] = np.nan
    scale = distances(seen.frame, seen.label, points, board).scale
    larger = Similarity(np.eye(3), np.zeros(3), scale)
    first, points = larger.camera(placed[0]), larger.points(points)
    room = _origin(cameras[0], first) if floor is None else _on_floor(seen, points, board, floor)
    placed, points = tuple(room.after(larger).camera(camera) for camera in placed), room.points(points)
    apart = distances(seen.frame, seen.label, points, board)
    rejected = seen.seen.sum(axis=0) - np.isfinite(residual).sum(axis=0)
    _require_agreement(seen, rejected)
    return BoardCalibration(placed, seen, points, residual, rejected, pairs, apart, scale)


def _require_agreement(seen: Sightings, rejected: Array) -> None:
    """Raises FollowspotError if most of what a camera saw contradicts the others."""
    share = rejected / np.maximum(1, seen.seen.sum(axis=0))
    worst = int(share.argmax())
    if share[worst] > MOST_REJECTED:
        raise FollowspotError(
            f"{share[worst]:.0%} of the corners in {seen.cameras[worst]} contradict the other cameras: "
            "is its recording of the same take, in step with the others, and its lens as the room has it?"
        )


def _started(
    cameras: Sequence[Camera], views: Mapping[str, Sequence[View]], board: Board
) -> tuple[Pairs, tuple[Camera, ...]]:
    """Initial poses of the cameras. Raises FollowspotError, which tells of exchanged recordings."""
    try:
        return start(cameras, views, board)
    except FollowspotError as error:
        raise exchange_that_helps(cameras, lambda tried: start(tried, views, board)) or error from None


def start(
    cameras: Sequence[Camera], views: Mapping[str, Sequence[View]], board: Board
) -> tuple[Pairs, tuple[Camera, ...]]:
    """The poses of cameras that see the board together. Raises FollowspotError."""
    seen = [
        {view.frame: board_poses(camera, view, board) for view in views[camera.name]} for camera in cameras
    ]
    pairs = relations(seen)
    poses = chained([camera.name for camera in cameras], pairs)
    placed = zip(cameras, poses, strict=True)
    return pairs, tuple(replace(c, rotation=p.rotation, translation=p.shift) for c, p in placed)


def _origin(before: Camera, after: Camera) -> Similarity:
    """From the present frame to the one in which a camera stands as before."""
    known = Similarity(before.rotation, before.translation)
    return known.inverse.after(Similarity(after.rotation, after.translation))


def _on_floor(seen: Sightings, points: Array, board: Board, moment: int) -> Similarity:
    """To the frame of a board on the floor. Raises FollowspotError if it was not seen."""
    rows = (seen.frame == moment) & np.isfinite(points).all(axis=1)
    corners = board.corners[seen.label[rows]] @ FLOOR.T
    if rows.sum() < 4 or on_a_line(corners):
        known = np.unique(seen.frame[np.isfinite(points).all(axis=1)])
        nearest = known[np.abs(known - moment).argmin()] if len(known) else "none"
        raise FollowspotError(
            f"--floor {moment}: two cameras do not see the board then; the nearest moment is {nearest}"
        )
    return similarity(points[rows], corners, scaled=False)

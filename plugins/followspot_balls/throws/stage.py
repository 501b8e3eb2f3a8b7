"""Thrown balls in one camera: blobs that move like the image of a parabola become tracks."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.plain_values import from_plain, to_plain
from followspot.tracking import Blobs, ImageTracks
from followspot_balls.throws.motion import Paths, assigned, initiated, predicted, updated
from followspot_balls.throws.parabola import bend, residual

MEMORY = 240
"""Number of the newest blobs that determine a path's shape: two seconds of a fast camera, longer than a
throw."""
CLEAR = 5.0
"""Smallest rise of a path over its residual: excludes noise that looks curved."""
NO_PATHS = initiated(0, np.empty(0, int), np.empty((0, 2)), (0.0, 0.0, 0.0))


class Throws(Stage):
    """Track balls in free flight in one picture; paths that rest, drift or jump are not reported.

    A path becomes a track once it is long and curved enough, and stays one while a parabola fits. Blobs cut
    by the edge of the picture are ignored, because their centroid is not the ball's. A ball that bounces or
    is caught leaves the gate and initiates another path.
    """

    per_camera = True

    class Params(StageParams):
        minimum_blobs: int = Field(
            12,
            ge=6,
            le=MEMORY,
            unit="1",
            description="fewest blobs of a track; raising it reports later and rejects more",
        )
        minimum_extent: float = Field(
            40.0,
            gt=0,
            unit="px",
            description="smallest extent of a path; raising it rejects tremor and distant throws",
        )
        minimum_sagitta: float = Field(
            4.0,
            gt=0,
            unit="px",
            description="smallest rise above the chord; raising it reports later and rejects rolling balls",
        )
        maximum_residual: float = Field(
            3.0,
            gt=0,
            unit="px",
            description="largest RMS distance from a parabola's image; raising it tolerates lens distortion",
        )
        gate: float = Field(
            3.5,
            gt=0,
            unit="sigma",
            description="largest distance of a blob from the forecast; raising it tolerates blur",
        )
        blob_sigma: float = Field(
            1.5, gt=0, unit="px", description="sigma of a blob's centre; raising it smooths more"
        )
        initial_velocity_sigma: float = Field(
            800.0,
            gt=0,
            unit="px/s",
            description="sigma of a new path's velocity; raising it catches faster throws",
        )
        initial_acceleration_sigma: float = Field(
            1500.0,
            gt=0,
            unit="px/s^2",
            description="sigma of a new path's acceleration; raising it catches more curved throws",
        )
        jerk_sigma: float = Field(
            600.0,
            gt=0,
            unit="px/s^2",
            description="sigma of the change of acceleration in a second; raising it tolerates perspective",
        )
        maximum_missed_frames: int = Field(
            5,
            ge=0,
            unit="frames",
            description="frames without a blob until a path is deleted; raising it bridges more",
        )

    params: Params

    def setup(self) -> None:
        self.paths = NO_PATHS
        self.points: dict[int, deque[tuple[float, float, float]]] = {}
        self.time = 0.0
        self.initiated_paths = 0
        self.largest = np.array(self.camera.size) - 1.0

    def process(self, blobs: Blobs) -> ImageTracks:
        row, target = np.nonzero(blobs.targets & self.whole(blobs)[:, None])
        xy = blobs.xy[row]
        path, blob = self.followed(blobs.header.time * NANOSECOND, target, xy)
        shape = np.array([self.judged(number) for number in self.paths.number[path].tolist()])
        thrown = np.flatnonzero(np.isfinite(shape))
        path, blob = path[thrown], blob[thrown]
        return ImageTracks(
            camera=blobs.camera,
            target=target[blob].astype("i4"),
            track=self.paths.number[path].astype("i4"),
            xy=xy[blob],
            pixel=blobs.pixel[row[blob]],
            velocity=self.paths.state[path, 1],
            residual=shape[thrown],
        )

    def state(self) -> Any:
        points = {number: list(points) for number, points in self.points.items()}
        return {
            "paths": to_plain(self.paths),
            "points": to_plain(points),
            "time": self.time,
            "initiated_paths": self.initiated_paths,
        }

    def restore(self, state: Any) -> None:
        self.paths = from_plain(Paths, state["paths"])
        points = from_plain(dict[int, list[tuple[float, float, float]]], state["points"])
        self.points = {number: deque(known, maxlen=MEMORY) for number, known in points.items()}
        self.time, self.initiated_paths = float(state["time"]), int(state["initiated_paths"])

    def whole(self, blobs: Blobs) -> Array:
        """Blobs that the edge of the picture does not cut: (N,) bool."""
        inside = np.minimum(blobs.pixel, self.largest - blobs.pixel).min(axis=1)
        return np.asarray(inside > np.sqrt(blobs.area / np.pi))

    def followed(self, time: float, target: Array, xy: Array) -> tuple[Array, Array]:
        """Continue the paths to now (s) with blobs of targets (N,) at xy (N, 2); rows of paths and blobs."""
        p = self.params
        paths = predicted(self.paths, time - self.time, p.jerk_sigma)
        self.time = time
        path, blob = assigned(paths, target, xy, p.blob_sigma, p.gate)
        paths = updated(paths, path, xy[blob], p.blob_sigma)
        fresh = np.setdiff1d(np.arange(len(target)), blob)
        sigma = (p.blob_sigma, p.initial_velocity_sigma, p.initial_acceleration_sigma)
        blob = np.concatenate([blob, fresh])
        path = np.concatenate([path, len(paths.number) + np.arange(len(fresh))])
        paths = paths.and_also(initiated(self.initiated_paths, target[fresh], xy[fresh], sigma))
        self.initiated_paths += len(fresh)
        self.remember(time, paths.number[path], xy[blob])
        return self.without_deleted(paths, path), blob

    def remember(self, time: float, number: Array, xy: Array) -> None:
        """Append a position (px) at a time (s) to each of these paths."""
        for key, (u, v) in zip(number.tolist(), xy.tolist(), strict=True):
            self.points.setdefault(key, deque(maxlen=MEMORY)).append((time, u, v))

    def without_deleted(self, paths: Paths, seen: Array) -> Array:
        """Delete paths that were missed too long; returns the new row numbers of the rows `seen`."""
        keep = paths.missed <= self.params.maximum_missed_frames
        for number in paths.number[~keep].tolist():
            del self.points[number]
        self.paths = paths.take(keep)
        return np.asarray(np.cumsum(keep) - 1)[seen]

    def judged(self, number: int) -> float:
        """Residual of a path that moves like a throw, px; infinite for any other."""
        p = self.params
        if len(self.points[number]) < p.minimum_blobs:
            return np.inf
        points = np.array(self.points[number])
        time, xy = points[:, 0], points[:, 1:]
        if np.ptp(xy, axis=0).max() < p.minimum_extent:
            return np.inf
        rise = bend(time, xy[:, 1])
        if rise < p.minimum_sagitta:
            return np.inf
        shape = residual(time, xy)
        return shape if shape <= min(p.maximum_residual, rise / CLEAR) else np.inf

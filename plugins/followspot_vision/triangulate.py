"""Points in the room from labelled points in the pictures of several cameras."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from followspot import Array, Camera, Field, Joined, Mistake, Room, Stage, StageParams
from followspot.geometry import back_projection
from followspot.points import Points2D, Points3D
from followspot.two_views import check_two_views
from followspot_vision.consensus import ConsensusPoint, ViewPoints, consensus_points


class Triangulate(Stage):
    """Triangulate points of the same label in several pictures; each point is used once.

    One label may have several positions, for example the noses of several persons. Points without a partner,
    such as false detections, are left out.
    """

    class Params(StageParams):
        point_sigma: float = Field(
            1.0, gt=0, unit="px", description="sigma of a point; raising it raises the covariances"
        )
        maximum_error: float = Field(
            4.0,
            gt=0,
            unit="px",
            description="largest distance of a point from the image of its position; raising it tolerates "
            "bad calibration, but joins points of different things",
        )
        minimum_views: int = Field(
            2, ge=2, unit="1", description="cameras that must agree; raising it avoids mistakes"
        )
        maximum_sigma: float = Field(
            0.2,
            gt=0,
            unit="m",
            description="largest sigma of a position; with a larger one its rays are nearly parallel, and "
            "it is left out",
        )
        maximum_points: int = Field(
            20,
            ge=1,
            le=1000,
            unit="1",
            description="points of one label in a picture, those with the best scores; raising it costs time",
        )

    params: Params

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn if fewer than two cameras send points, or all stand at one place."""
        return check_two_views(cameras, "a place needs points of")

    def setup(self) -> None:
        cameras = self.room.cameras
        self.number = {name: number for number, name in enumerate(cameras)}
        self.projection = np.array([c.projection for c in cameras.values()]).reshape(-1, 3, 4)
        self.back = np.array([back_projection(c) for c in cameras.values()]).reshape(-1, 3, 3)
        self.center = np.array([c.center for c in cameras.values()]).reshape(-1, 3)

    def process(self, points: Joined[Points2D]) -> Points3D:
        labels = tuple(dict.fromkeys(label for one in points for label in one.labels))
        kept = [(one, self.best_rows(one)) for one in points]
        label = _joined([_indices(one.labels, labels)[one.label[rows]] for one, rows in kept], "i4")
        camera = _joined([np.full(len(rows), self.number[one.camera]) for one, rows in kept], "i4")
        xy = np.concatenate([np.zeros((0, 2)), *(one.xy[rows] for one, rows in kept)])
        score = _joined([one.score[rows] for one, rows in kept], "f8")
        in_views = self.in_views(camera, xy)
        gate, views = self.params.maximum_error, self.params.minimum_views
        found: list[tuple[int, ConsensusPoint, float]] = []
        for number in range(len(labels)):
            own = np.flatnonzero(label == number)
            agreed = consensus_points(in_views.rows(own), gate, views)
            found += [(number, point, float(score[own[point.rows]].mean())) for point in agreed]
        return self.message(labels, found)

    def best_rows(self, points: Points2D) -> Array:
        """Rows with a known position, of each label those with the best scores, in their order."""
        rows = np.flatnonzero(np.isfinite(points.xy).all(axis=1))
        if len(rows) <= self.params.maximum_points:
            return rows
        order = rows[np.argsort(-points.score[rows], kind="stable")]
        order = order[np.argsort(points.label[order], kind="stable")]
        first = np.searchsorted(points.label[order], points.label[order])
        return np.sort(order[np.arange(len(order)) - first < self.params.maximum_points])

    def in_views(self, camera: Array, xy: Array) -> ViewPoints:
        """The points with their cameras and rays."""
        back = self.back[camera]
        ray = back[..., 0] * xy[:, :1] + back[..., 1] * xy[:, 1:] + back[..., 2]
        ray /= np.linalg.norm(ray, axis=1, keepdims=True)
        return ViewPoints(camera, xy, self.projection[camera], self.center[camera], ray)

    def message(
        self, labels: tuple[str, ...], found: Sequence[tuple[int, ConsensusPoint, float]]
    ) -> Points3D:
        """The points of the room that are determined well enough."""
        normal = np.array([point.normal for _, point, _ in found]).reshape(-1, 3, 3)
        covariance = self.params.point_sigma**2 * np.linalg.inv(normal)
        sure = np.linalg.eigvalsh(covariance)[:, -1] <= self.params.maximum_sigma**2
        return Points3D(
            labels=labels,
            label=np.array([number for number, _, _ in found], "i4"),
            xyz=np.array([point.xyz for _, point, _ in found]).reshape(-1, 3),
            covariance=covariance,
            views=np.array([len(point.rows) for _, point, _ in found], "i4"),
            error=np.array([point.error for _, point, _ in found], "f8"),
            score=np.array([score for _, _, score in found], "f8"),
        ).where(sure)


def _indices(labels: Sequence[str], among: Sequence[str]) -> Array:
    index = {label: number for number, label in enumerate(among)}
    return np.array([index[label] for label in labels], int)


def _joined(parts: Sequence[Array], dtype: str) -> Array:
    return np.concatenate([np.zeros(0, dtype), *(part.astype(dtype) for part in parts)])

"""Poses of markers in the room, from their corners in one camera or several."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from followspot import Array, Field, Joined, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.points import Points3D
from followspot_vision.marker_messages import MarkerPoses, Markers
from followspot_vision.square_pose import Pose, poses, quaternion

TURN_SIGMA = 0.1
"""Sigma of the angle between two faces of a marker that does not turn, rad."""
MINIMUM_LOG_LIKELIHOOD = -40.0
"""Smallest log-likelihood of a pose, relative to the other: a marker may also turn unseen."""


class PoseHypotheses(NamedTuple):
    """The poses that a marker may have, for it may lean to the camera or away from it."""

    normals: Array
    """(K, 3), directions of the face."""
    log_likelihood: Array
    """(K,), 0 of the best."""
    time: int
    """ns."""


@dataclass(frozen=True)
class Outputs:
    """The poses, and the middles of the markers as points with the markers' names."""

    poses: MarkerPoses
    points: Points3D


class FindMarkerPoses(Stage):
    """Find each marker's pose, from all cameras that see it; one is enough.

    One view of a flat square allows two poses: it may lean towards the camera or away from it. The stage
    follows both from frame to frame, with likelihoods from their corners and their turns, and gives the more
    likely one.
    """

    class Params(StageParams):
        size: float = Field(0.1, gt=0, unit="m", description="side of a marker, its black border included")
        sizes: dict[str, float] = Field(
            {}, unit="m", description="sides of markers by name, where they differ"
        )
        maximum_error: float = Field(
            3.0,
            gt=0,
            unit="px",
            description="largest RMS distance of the corners from their images; raising it tolerates bad "
            "calibration",
        )
        corner_sigma: float = Field(
            0.2, gt=0, unit="px", description="sigma of a corner; raising it avoids flips to the other pose"
        )
        turn_rate: float = Field(
            3.0, ge=0, unit="rad/s", description="how fast markers turn; raising it follows faster turns"
        )
        memory: float = Field(
            1.0, ge=0, unit="s", description="time for which the poses of an unseen marker are remembered"
        )

    params: Params
    seen: frozenset[str] = frozenset()
    """Names of the markers seen so far."""

    def setup(self) -> None:
        self.hypotheses: dict[str, PoseHypotheses] = {}

    def process(self, markers: Joined[Markers]) -> Outputs:
        seen: dict[str, list[tuple[str, Array]]] = {}
        for one in markers:
            for row, index in enumerate(one.marker.tolist()):
                seen.setdefault(one.names[index], []).append((one.camera, one.xy[row]))
        self.seen |= seen.keys()
        time = max((one.header.time for one in markers), default=0)
        self.hypotheses = {name: s for name, s in self.hypotheses.items() if not self.is_outdated(s, time)}
        found = {name: self.pose(name, views, time) for name, views in sorted(seen.items())}
        kept = {name: pose for name, pose in found.items() if pose is not None}
        names, count = tuple(kept), len(kept)
        number = np.arange(count, dtype=np.int32)
        xyz = np.array([pose.xyz for pose, _ in kept.values()]).reshape(-1, 3)
        spread = np.array([pose.spread for pose, _ in kept.values()]).reshape(-1, 3, 3)
        views = np.array([len(seen[name]) for name in names], np.int32)
        error = np.array([pose.error for pose, _ in kept.values()])
        rotation = np.array([quaternion(pose.rotation) for pose, _ in kept.values()]).reshape(-1, 4)
        ambiguity = np.array([ambiguity for _, ambiguity in kept.values()])
        return Outputs(
            poses=MarkerPoses(
                names=names,
                marker=number,
                xyz=xyz,
                rotation=rotation,
                views=views,
                error=error,
                ambiguity=ambiguity,
            ),
            points=Points3D(
                labels=names,
                label=number,
                xyz=xyz.copy(),
                covariance=spread * self.params.corner_sigma**2,
                views=views.copy(),
                error=error.copy(),
                score=np.ones(count),
            ),
        )

    def close(self) -> None:
        """Warn of sizes whose markers were never seen: their names may be misspelt."""
        missed = sorted(self.params.sizes.keys() - self.seen)
        if missed:
            among = ", ".join(sorted(self.seen)) or "none"
            self.log.warning("sizes names %s, never seen; markers seen: %s", ", ".join(missed), among)

    def pose(self, name: str, views: list[tuple[str, Array]], time: int) -> tuple[Pose, float] | None:
        """The pose of a marker and its ambiguity; None if its corners do not fit a square of its size."""
        cameras = [self.room.cameras[camera] for camera, _ in views]
        size = self.params.sizes.get(name, self.params.size)
        possible = poses(cameras, np.array([xy for _, xy in views]), size)[:2]
        if not possible or possible[0].error > self.params.maximum_error:
            return None
        errors = np.array([pose.error for pose in possible])
        log_likelihood = -2 * len(views) * np.square(errors / self.params.corner_sigma)  # four corners a view
        normals = np.array([pose.rotation[:, 2] for pose in possible])
        before = self.hypotheses.get(name)
        if before is not None:
            log_likelihood += self.transition_log_likelihood(before, normals, time)
        relative = np.maximum(log_likelihood - log_likelihood.max(), MINIMUM_LOG_LIKELIHOOD)
        self.hypotheses[name] = PoseHypotheses(normals, relative, time)
        ambiguity = errors[0] / max(errors[1], np.finfo(float).tiny) if len(errors) > 1 else 0.0
        return possible[int(log_likelihood.argmax())], float(ambiguity)

    def transition_log_likelihood(self, before: PoseHypotheses, normals: Array, time: int) -> Array:
        """Log-likelihood of normals (K, 3) after the previous hypotheses, by the turns to them: (K,)."""
        sigma = TURN_SIGMA + self.params.turn_rate * (time - before.time) * NANOSECOND
        angle = np.arccos(np.clip(normals @ before.normals.T, -1, 1))
        return np.asarray((before.log_likelihood - np.square(angle / sigma) / 2).max(axis=1))

    def is_outdated(self, hypotheses: PoseHypotheses, time: int) -> bool:
        """Whether poses are too old to count, or of a time that has not come yet."""
        return not 0 <= (time - hypotheses.time) * NANOSECOND <= self.params.memory

    def state(self) -> Any:
        return {name: list(hypotheses) for name, hypotheses in self.hypotheses.items()}

    def restore(self, state: Any) -> None:
        self.hypotheses = {
            name: PoseHypotheses(np.array(normals), np.array(log_likelihood), int(time))
            for name, (normals, log_likelihood, time) in state.items()
        }

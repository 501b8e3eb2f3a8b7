"""Body model of the tracker of people whose detections are joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_persons.associate.assignment.affinity import pair_ratios
from followspot_persons.associate.existence import OddsLimits
from followspot_persons.associate.joints import tracks as joint_tracks
from followspot_persons.associate.joints.agreement import agreement
from followspot_persons.associate.joints.point_ratios import labelled, log_ratios
from followspot_persons.associate.joints.reversal import righted
from followspot_persons.associate.joints.sides import Sides, sides_of, unknown
from followspot_persons.associate.joints.tracks import JointTracks, expected, speeds
from followspot_persons.associate.multi_view.triangulation import triangulated
from followspot_persons.associate.multi_view.views import Noise, View, Views, images

LEAST = 3
"""Joints that two cameras must see of a new body."""
INITIAL_GAIN = 5.0
"""What each detection of a new body adds to its log-odds if enough joints of the cameras agree."""
ENOUGH, SHARE = 10, 0.6
"""How many more joints must agree than not: this number, or this share of all if they are few."""
DISTANT = 0.3
"""Largest median sigma of a new body's joints, m: rays that are nearly parallel agree about everything."""
LOWEST, HIGHEST = -0.3, 2.6
"""Where most joints of a new body are above the floor, m."""
UNSEEN = 0.5
"""Sigma of the place of a joint that was never seen about the middle of its body, m."""
WALKING = 1.0
"""Sigma of the velocity of a new body, m/s."""
MARGIN = 0.1
"""What a body reaches beyond its joints, as a share of their extent."""


@dataclass(frozen=True)
class JointModel:
    """Names of the J joints, errors of found points, number of cameras, plane of the floor, (4,), if any."""

    joints: tuple[str, ...]
    noise: Noise
    cameras: int
    floor: tuple[float, ...] | None = None
    odds_limits = OddsLimits(initial=-5.0, detection=4.0)

    @property
    def sides(self) -> Sides:
        """The sides of the joints."""
        return sides_of(self.joints)

    def initial_gain(self, body: JointTracks, views: Views, camera: Array, measured: Array) -> float:
        """What each detection of a new body adds to its log-odds: the more joints agree, the more."""
        agree = agreement(views, camera, measured, body.xyz[0], self.noise)
        return INITIAL_GAIN * float(np.clip(agree / min(ENOUGH, SHARE * len(self.joints)), 0.0, 1.0))

    def none(self) -> JointTracks:
        """No bodies."""
        return JointTracks.none(len(self.joints), self.cameras)

    def predicted(self, tracks: JointTracks, seconds: float) -> JointTracks:
        """The bodies some time later."""
        return joint_tracks.predicted(tracks, seconds, *speeds(self.joints))

    def log_ratios(self, tracks: JointTracks, view: View, measured: Array) -> Array:
        """(M, N) of detections (N, J, 2) px being these bodies."""
        return log_ratios(tracks, expected(tracks, view, self.noise), view, measured, self.sides)

    def updated(
        self, tracks: JointTracks, rows: Array, view: View, measured: Array, probability: Array
    ) -> JointTracks:
        """The bodies after their detections (K, J, 2) px."""
        own = tracks.where(rows)
        points = expected(own, view, self.noise)
        own, xy = labelled(own, points, view, measured, self.sides)
        return tracks.replaced(rows, joint_tracks.updated(own, points, xy, probability))

    def pair_ratios(self, views: Views, camera: Array, measured: Array) -> Array:
        """(N, N) of two detections of different cameras being one body."""
        return pair_ratios(views, camera, measured, self.noise)

    def initiated(self, views: Views, camera: Array, measured: Array) -> JointTracks | None:
        """The body of detections (V, J, 2) px of different cameras; None if they determine none."""
        joints = triangulated(views, camera, measured, self.noise)
        known = joints.views > 0
        if known.sum() < LEAST or not self.is_sure(joints.xyz[known], joints.covariance[known]):
            return None
        middle = joints.xyz[known].mean(axis=0)
        count, unseen = len(self.joints), np.eye(3) * UNSEEN**2
        exchanged, reversal = unknown(1, self.cameras)
        body = JointTracks(
            xyz=np.where(known[:, None], joints.xyz, middle)[None],
            velocity=np.zeros((1, count, 3)),
            position_covariance=np.where(known[:, None, None], joints.covariance, unseen)[None],
            cross_covariance=np.zeros((1, count, 3, 3)),
            velocity_covariance=np.broadcast_to(np.eye(3) * WALKING**2, (1, count, 3, 3)).copy(),
            views=joints.views[None],
            known=known[None],
            exchanged=exchanged,
            reversal=reversal,
        )
        for number, xy in zip(camera, measured, strict=True):
            view = views.each[number]
            body, _ = labelled(body, expected(body, view, self.noise), view, xy[None], self.sides)
        return body

    def is_sure(self, xyz: Array, covariance: Array) -> bool:
        """Whether the places of a new body's joints, (K, 3) m, are known well enough and above the floor."""
        sigma = np.sqrt(np.linalg.eigvalsh(covariance)[:, -1])
        if np.median(sigma) > DISTANT:
            return False
        if self.floor is None:
            return True
        level = xyz @ np.array(self.floor[:3]) + self.floor[3]
        return bool(np.quantile(level, 0.1) > LOWEST and np.quantile(level, 0.9) < HIGHEST)

    def before_set(self, tracks: JointTracks) -> JointTracks:
        """The bodies before a set: no camera saw them yet."""
        return righted(tracks.unseen(), self.joints, self.sides)

    def shifted(self, tracks: JointTracks, seconds: float) -> JointTracks:
        """The bodies a little earlier or later, as certain as they are."""
        return replace(tracks, xyz=tracks.xyz + seconds * tracks.velocity)

    def middle(self, tracks: JointTracks) -> Array:
        """Middle of each body, (M, 3) m."""
        weight = tracks.known / np.maximum(tracks.known.sum(axis=1, keepdims=True), 1)
        return np.asarray((tracks.xyz * weight[..., None]).sum(axis=1))

    def bounding_boxes(self, tracks: JointTracks, view: View) -> tuple[Array, Array]:
        """Boxes x0, y0, x1, y1 (M, 4) px about the bodies in a picture, and their depths (M,) m; NaN if there
        are none.
        """
        there, depth = images(view.projection, tracks.xyz)
        seen = tracks.known & np.isfinite(depth)
        low = np.where(seen[..., None], there, np.inf).min(axis=1, initial=np.inf)
        high = np.where(seen[..., None], there, -np.inf).max(axis=1, initial=-np.inf)
        low, high = (np.where(np.isfinite(end), end, np.nan) for end in (low, high))
        margin = MARGIN * (high - low)
        number = np.maximum(seen.sum(axis=1), 1)
        distance = np.where(seen, depth, 0.0).sum(axis=1) / number
        return np.hstack([low - margin, high + margin]), np.where(seen.any(axis=1), distance, np.nan)

    def widened(self, tracks: JointTracks, names: Sequence[str]) -> tuple[JointModel, JointTracks]:
        """The model and the bodies with more joints."""
        wider = replace(self, joints=(*self.joints, *names))
        return wider, tracks.widened(len(names), self.middle(tracks), UNSEEN)

"""Bodies as joints: each has a position, a velocity and their covariance, and is measured in pictures."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from followspot import Array
from followspot_persons.associate.joints import sides
from followspot_persons.associate.motion import step
from followspot_persons.associate.multi_view.point_errors import OUTLIER
from followspot_persons.associate.multi_view.views import Noise, View, images, jacobians
from followspot_persons.associate.rows import Rows

BODY_SPEED, BODY_MEMORY = 1.0, 1.0
"""Sigma of the velocity of head and trunk, m/s, and the time in which it fades, s."""
LIMB_SPEED, LIMB_MEMORY = 1.5, 0.5
"""The same of arms and legs."""
LIMBS = ("elbow", "wrist", "knee", "ankle", "toe", "heel", "hand", "foot")
_EYE = np.eye(3)


@dataclass(frozen=True, eq=False)
class JointTracks(Rows):
    """M bodies of J joints. xyz, velocity: (M, J, 3) m, m/s; (M, J, 3, 3) covariances of position, of
    position with velocity, and of velocity; views: (M, J) cameras that saw the joint in the last set;
    known: (M, J) whether it was ever measured; exchanged, reversal: (M, C, G, 2), (M, G) log-odds of
    `followspot_persons.associate.joints.sides`, of C cameras and G parts.
    """

    xyz: Array
    velocity: Array
    position_covariance: Array
    cross_covariance: Array
    velocity_covariance: Array
    views: Array
    known: Array
    exchanged: Array
    reversal: Array

    @classmethod
    def none(cls, joints: int, cameras: int) -> JointTracks:
        """No bodies."""
        vector, matrix = np.zeros((0, joints, 3)), np.zeros((0, joints, 3, 3))
        flags = np.zeros((0, joints))
        odds = sides.unknown(0, cameras)
        return cls(vector, vector, matrix, matrix, matrix, flags.astype(int), flags.astype(bool), *odds)

    def unseen(self) -> JointTracks:
        """The same bodies; no camera has seen them yet."""
        return replace(self, views=np.zeros_like(self.views))

    def widened(self, joints: int, middle: Array, sigma: float) -> JointTracks:
        """The bodies with more joints, of which only the body's middle (M, 3) m is known, within sigma, m."""
        shape = (len(self), joints)
        velocity = self.velocity.mean(axis=1) if self.velocity.shape[1] else np.zeros((len(self), 3))
        matrix = np.broadcast_to(_EYE, (*shape, 3, 3))
        more = (
            np.broadcast_to(middle[:, None], (*shape, 3)),
            np.broadcast_to(velocity[:, None], (*shape, 3)),
            sigma**2 * matrix,
            0.0 * matrix,
            LIMB_SPEED**2 * matrix,
            np.zeros(shape, int),
            np.zeros(shape, bool),
        )
        pairs = zip(JOINT_FIELDS, more, strict=True)
        return replace(self, **{name: np.concatenate([getattr(self, name), part], 1) for name, part in pairs})

    def replaced(self, rows: Array, bodies: JointTracks) -> JointTracks:
        """The bodies with others in these rows (K,)."""
        found = {name: values.copy() for name, values in vars(self).items()}
        for name, values in vars(bodies).items():
            found[name][rows] = values
        return JointTracks(**found)


JOINT_FIELDS = tuple(one.name for one in fields(JointTracks) if one.name not in ("exchanged", "reversal"))
"""Fields that have a row for each joint, (M, J, ...)."""


def speeds(joints: tuple[str, ...]) -> tuple[Array, Array]:
    """Sigma of the velocity, m/s, and its memory, s, of each joint, (J,) each, by its name."""
    limb = np.array([any(word in name for word in LIMBS) for name in joints], bool)
    return np.where(limb, LIMB_SPEED, BODY_SPEED), np.where(limb, LIMB_MEMORY, BODY_MEMORY)


def predicted(tracks: JointTracks, seconds: float, sigma: Array, memory: Array) -> JointTracks:
    """The bodies some time later. sigma, memory: (J,), of :func:`speeds`."""
    fade, reach, position, cross, velocity = (part[:, None, None] for part in step(seconds, sigma, memory))
    transposed = np.swapaxes(tracks.cross_covariance, -1, -2)
    return replace(
        tracks,
        xyz=tracks.xyz + reach[:, 0] * tracks.velocity,
        velocity=fade[:, 0] * tracks.velocity,
        position_covariance=tracks.position_covariance
        + reach * (tracks.cross_covariance + transposed)
        + reach**2 * tracks.velocity_covariance
        + position * _EYE,
        cross_covariance=fade * (tracks.cross_covariance + reach * tracks.velocity_covariance) + cross * _EYE,
        velocity_covariance=fade**2 * tracks.velocity_covariance + velocity * _EYE,
        exchanged=sides.predicted(tracks.exchanged, seconds),
    )


@dataclass(frozen=True, eq=False)
class PredictedPoints:
    """Predicted points in a picture. there: (M, J, 2) px; slope: (M, J, 2, 3) px/m; spread: (M, J, 2, 2)
    px^2 of the prediction alone; error: (M, J, 2, 2) px^2 of a found point.
    """

    there: Array
    slope: Array
    spread: Array
    error: Array


def expected(tracks: JointTracks, view: View, noise: Noise) -> PredictedPoints:
    """Images of the joints and their uncertainty; NaN for joints that the camera cannot see."""
    there, depth = images(view.projection, tracks.xyz)
    slope = jacobians(view.projection, there, depth)
    spread = slope @ tracks.position_covariance @ np.swapaxes(slope, -1, -2)
    own = noise.pixel**2 + (view.focal * noise.body / depth) ** 2
    shift = noise.delay * (slope @ tracks.velocity[..., None])[..., 0]
    error = own[..., None, None] * np.eye(2) + shift[..., :, None] * shift[..., None, :]
    return PredictedPoints(there, slope, spread, error)


def updated(tracks: JointTracks, points: PredictedPoints, xy: Array, probability: Array) -> JointTracks:
    """The bodies after a detection of each, by the Kalman filter of each joint.

    points: of the bodies; xy: (M, J, 2) px, NaN for joints that were not found; probability: (M,) that a
    detection is the body's. The variance of a point far from its expectation grows with its squared distance.
    """
    found = np.asarray(np.isfinite(xy + points.there).all(axis=-1))
    residual = np.where(found[..., None], xy - points.there, 0.0)
    H = np.where(found[..., None, None], points.slope, 0.0)
    spread, error = (
        np.where(found[..., None, None], part, np.eye(2)) for part in (points.spread, points.error)
    )
    squared = np.vecdot(residual, np.linalg.solve(spread + error, residual[..., None])[..., 0])
    S = spread + error * np.maximum(1.0, squared / OUTLIER)[..., None, None]
    inverse, across = np.linalg.inv(S), np.swapaxes(H, -1, -2)
    gain = tracks.position_covariance @ across @ inverse
    gain_of_velocity = np.swapaxes(tracks.cross_covariance, -1, -2) @ across @ inverse
    theirs = probability[:, None, None, None]
    spare = S - (1 - theirs) * residual[..., :, None] * residual[..., None, :]
    gained, gained_of_velocity = theirs * gain @ spare, theirs * gain_of_velocity @ spare
    transposed, transposed_of_velocity = np.swapaxes(gain, -1, -2), np.swapaxes(gain_of_velocity, -1, -2)
    return replace(
        tracks,
        xyz=tracks.xyz + (theirs * gain @ residual[..., None])[..., 0],
        velocity=tracks.velocity + (theirs * gain_of_velocity @ residual[..., None])[..., 0],
        position_covariance=tracks.position_covariance - gained @ transposed,
        cross_covariance=tracks.cross_covariance - gained @ transposed_of_velocity,
        velocity_covariance=tracks.velocity_covariance - gained_of_velocity @ transposed_of_velocity,
        views=tracks.views + found,
        known=tracks.known | found,
    )

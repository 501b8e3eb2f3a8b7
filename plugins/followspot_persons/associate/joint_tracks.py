"""Bodies as joints: each has a position, a velocity and their covariance, and is measured in pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_persons.associate.motion import step
from followspot_persons.associate.rows import Rows
from followspot_persons.associate.views import Noise, View, images, jacobians

BODY_SPEED, BODY_MEMORY = 1.0, 1.0
"""Sigma of the velocity of head and trunk, m/s, and the time in which it fades, s."""
LIMB_SPEED, LIMB_MEMORY = 1.5, 0.5
"""The same of arms and legs."""
LIMBS = ("elbow", "wrist", "knee", "ankle", "toe", "heel", "hand", "foot")
OUTLIER = 9.0
"""Squared normalised distance above which a point's variance grows with it: a bound on its influence."""
WRONG = 0.1
"""Share of a network's points that are anywhere."""
INDEPENDENT = 4
"""Points of a body whose errors are independent: more of them are no more evidence."""
_EYE = np.eye(3)


@dataclass(frozen=True, eq=False)
class JointTracks(Rows):
    """M bodies of J joints. xyz, velocity: (M, J, 3) m, m/s; (M, J, 3, 3) covariances of position, of
    position with velocity, and of velocity; views: (M, J) cameras that saw the joint in the last set;
    known: (M, J) whether it was ever measured.
    """

    xyz: Array
    velocity: Array
    position_covariance: Array
    cross_covariance: Array
    velocity_covariance: Array
    views: Array
    known: Array

    @classmethod
    def none(cls, joints: int) -> JointTracks:
        """No bodies."""
        vector, matrix = np.zeros((0, joints, 3)), np.zeros((0, joints, 3, 3))
        flags = np.zeros((0, joints))
        return cls(vector, vector, matrix, matrix, matrix, flags.astype(int), flags.astype(bool))

    def unseen(self) -> JointTracks:
        """The same bodies; no camera has seen them yet."""
        return replace(self, views=np.zeros_like(self.views))

    def widened(self, joints: int, middle: Array, sigma: float) -> JointTracks:
        """The bodies with more joints, of which only the body's middle (M, 3) m is known, within sigma, m."""
        shape = (len(self), joints)
        velocity = self.velocity.mean(axis=1) if self.velocity.shape[1] else np.zeros((len(self), 3))
        matrix = np.broadcast_to(_EYE, (*shape, 3, 3))
        more = JointTracks(
            np.broadcast_to(middle[:, None], (*shape, 3)),
            np.broadcast_to(velocity[:, None], (*shape, 3)),
            sigma**2 * matrix,
            0.0 * matrix,
            LIMB_SPEED**2 * matrix,
            np.zeros(shape, int),
            np.zeros(shape, bool),
        )
        pairs = zip(vars(self).values(), vars(more).values(), strict=True)
        return JointTracks(*(np.concatenate(pair, axis=1) for pair in pairs))


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


def log_ratios(tracks: JointTracks, view: View, xy: Array, noise: Noise) -> Array:
    """Log-likelihood ratios that detections are these bodies, (M, N), against points anywhere in the picture.

    xy: (N, J, 2) px, NaN for joints that were not found. A share `WRONG` of the points may be anywhere.
    """
    points = expected(tracks, view, noise)
    S = points.spread + points.error
    determinant = S[..., 0, 0] * S[..., 1, 1] - S[..., 0, 1] ** 2
    x, y = np.moveaxis(xy[None] - points.there[:, None], -1, 0)
    squared = S[:, None, :, 1, 1] * x**2 + S[:, None, :, 0, 0] * y**2 - 2 * S[:, None, :, 0, 1] * x * y
    squared /= determinant[:, None]
    area = float(view.size.prod())
    right = np.exp(-squared / 2) * (area / (2 * np.pi)) / np.sqrt(determinant)[:, None]
    ratio = np.log((1 - WRONG) * right + WRONG)
    found = np.isfinite(ratio)
    count = found.sum(axis=2)
    mean = np.where(found, ratio, 0.0).sum(axis=2) / np.maximum(count, 1)
    return np.asarray(mean * np.minimum(count, INDEPENDENT))


def updated(tracks: JointTracks, rows: Array, view: View, xy: Array, noise: Noise) -> JointTracks:
    """The bodies after detections of one camera, by the Kalman filter of each joint.

    rows: (K,) the bodies; xy: (K, J, 2) px of their detections, NaN for joints that were not found. The
    variance of a point far from its expectation grows with its squared distance.
    """
    own = tracks.where(rows)
    points = expected(own, view, noise)
    found = np.asarray(np.isfinite(xy + points.there).all(axis=-1))
    residual = np.where(found[..., None], xy - points.there, 0.0)
    H = np.where(found[..., None, None], points.slope, 0.0)
    spread, error = (
        np.where(found[..., None, None], part, np.eye(2)) for part in (points.spread, points.error)
    )
    squared = np.vecdot(residual, np.linalg.solve(spread + error, residual[..., None])[..., 0])
    S = spread + error * np.maximum(1.0, squared / OUTLIER)[..., None, None]
    inverse, across = np.linalg.inv(S), np.swapaxes(H, -1, -2)
    gain = own.position_covariance @ across @ inverse
    gain_of_velocity = np.swapaxes(own.cross_covariance, -1, -2) @ across @ inverse
    gained, gained_of_velocity = gain @ S, gain_of_velocity @ S
    transposed, transposed_of_velocity = np.swapaxes(gain, -1, -2), np.swapaxes(gain_of_velocity, -1, -2)
    part = JointTracks(
        xyz=own.xyz + (gain @ residual[..., None])[..., 0],
        velocity=own.velocity + (gain_of_velocity @ residual[..., None])[..., 0],
        position_covariance=own.position_covariance - gained @ transposed,
        cross_covariance=own.cross_covariance - gained @ transposed_of_velocity,
        velocity_covariance=own.velocity_covariance - gained_of_velocity @ transposed_of_velocity,
        views=own.views + found,
        known=own.known | found,
    )
    return _replaced(tracks, rows, part)


def _replaced(tracks: JointTracks, rows: Array, part: JointTracks) -> JointTracks:
    """The bodies with other values in these rows."""
    found = {}
    for name, values in vars(tracks).items():
        found[name] = values.copy()
        found[name][rows] = getattr(part, name)
    return JointTracks(**found)

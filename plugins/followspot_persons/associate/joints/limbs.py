"""Arms and legs keep their lengths: each person's are learnt, left and right together, and joints obey.

A network's joints slide along arms and legs with the view. The length of each limb is a scalar that a Kalman
filter estimates from the joints of both sides; then both joints of each limb move, by their covariances,
until they are that far apart (iterated extended Kalman filter of an almost exact measurement; Bar-Shalom,
Li & Kirubarajan 2001, section 10.5).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_persons.associate.joints.tracks import JointTracks
from followspot_persons.associate.rows import Rows

USUAL = 1.72 * np.array([[0.186, 0.146], [0.245, 0.246]])
"""Lengths of upper arm, forearm; thigh, shin of adults, m (Drillis & Contini 1966)."""
SPREAD = 0.1
"""Relative sigma of these lengths over people."""
ALIKE = 30.0
"""Pictures in a row that share the errors of a network, and so count as one."""
SLACK = 0.005
"""Sigma of the distance between joints of one limb about its length, m: no joint turns about a point."""
NEAR = 0.5
"""Sigma of the vector between both joints over the length, up to which its direction is known."""
STEPS = 3
"""Linearisations of the distances."""
_CHAINS = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))
_SIDES = ("left", "right")


@dataclass(frozen=True, eq=False)
class Lengths(Rows):
    """number: (P,) of persons; mean, variance: (P, 2, 2) of arm and leg, upper and lower limb, m and m^2."""

    number: Array
    mean: Array
    variance: Array

    @classmethod
    def none(cls) -> Lengths:
        """The lengths of no person."""
        return cls(np.zeros(0, int), np.zeros((0, 2, 2)), np.zeros((0, 2, 2)))

    def of(self, number: Array) -> Lengths:
        """The lengths of numbered persons; unknown ones have those of people at large. number: (M,)."""
        mean = np.tile(USUAL, (len(number), 1, 1))
        variance = np.square(SPREAD * mean)
        row = {int(one): i for i, one in enumerate(self.number) if one > 0}
        for i, one in enumerate(number):
            if int(one) in row:
                mean[i], variance[i] = self.mean[row[int(one)]], self.variance[row[int(one)]]
        return Lengths(number, mean, variance)


def learnt(lengths: Lengths, joints: tuple[str, ...], bodies: JointTracks) -> Lengths:
    """The lengths after a set of pictures, by limbs both ends of which two cameras saw. One row a body."""
    chain = _chains(joints)
    if chain is None or not len(bodies):
        return lengths
    mean, variance = lengths.mean.copy(), lengths.variance.copy()
    direction, length = _limbs(bodies.xyz[:, chain])
    covariance = bodies.position_covariance[:, chain]
    sure = (bodies.views[:, chain] > 1).astype(float)
    both = covariance[..., :-1, :, :] + covariance[..., 1:, :, :]
    error = np.einsum("msclj,msclji,mscli->mscl", direction, both, direction)
    seen = sure[..., :-1] * sure[..., 1:]
    for side in range(2):
        gain = seen[:, side] * variance / (variance + ALIKE * error[:, side])
        mean += gain * (length[:, side] - mean)
        variance *= 1 - gain
    return replace(lengths, mean=mean, variance=variance)


def constrained(lengths: Lengths, joints: tuple[str, ...], bodies: JointTracks) -> JointTracks:
    """The bodies with arms and legs of these lengths, one row for each."""
    chain = _chains(joints)
    if chain is None or not len(bodies):
        return bodies
    start, prior = bodies.xyz[:, chain], bodies.position_covariance[:, chain]
    known, total = bodies.known[:, chain], np.trace(prior, axis1=-2, axis2=-1)
    near = total[..., :-1] + total[..., 1:] < np.square(NEAR * lengths.mean[:, None])
    counts = (known[..., :-1] & known[..., 1:] & near).astype(float)
    xyz = start
    for _ in range(STEPS):
        direction, length = _limbs(xyz)
        H = _slopes(direction * counts[..., None])
        across = np.einsum("mscjab,mscljb->mscjal", prior, H)
        S = np.einsum("mscljb,mscjbk->msclk", H, across) + SLACK**2 * np.eye(2)
        gain = np.einsum("mscjal,msclk->mscjak", across, np.linalg.inv(S))
        short = counts * (lengths.mean[:, None] - length) - np.einsum("mscljb,mscjb->mscl", H, start - xyz)
        xyz = start + np.einsum("mscjak,msck->mscja", gain, short)
    found, covariance = bodies.xyz.copy(), bodies.position_covariance.copy()
    found[:, chain], covariance[:, chain] = xyz, prior - np.einsum("mscjak,mscjbk->mscjab", gain, across)
    return replace(bodies, xyz=found, position_covariance=covariance)


def _limbs(xyz: Array) -> tuple[Array, Array]:
    """Directions (..., 2, 3) and lengths (..., 2) m of the limbs between three joints (..., 3, 3) m."""
    apart = np.diff(xyz, axis=-2)
    length = np.linalg.norm(apart, axis=-1)
    return apart / np.maximum(length, 1e-6)[..., None], length


def _slopes(direction: Array) -> Array:
    """Change (..., 2, 3, 3) of both lengths with each of the three joints. direction: (..., 2, 3)."""
    slope = np.zeros((*direction.shape[:-1], 3, 3))
    for limb in range(2):
        slope[..., limb, limb, :] = -direction[..., limb, :]
        slope[..., limb, limb + 1, :] = direction[..., limb, :]
    return slope


def _chains(joints: tuple[str, ...]) -> Array | None:
    """Joints of each side's arm and leg, (2, 2, 3); None if the names are not those of COCO."""
    names = [[[f"{side}_{joint}" for joint in chain] for chain in _CHAINS] for side in _SIDES]
    if not {name for side in names for chain in side for name in chain} <= set(joints):
        return None
    return np.array([[[joints.index(name) for name in chain] for chain in side] for side in names])

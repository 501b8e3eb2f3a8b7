"""Head, chest and stature of people from their joints, as the tracker of poses reports them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.geometry import wrap

EYES_UP, SHOULDERS_UP = 0.11, 0.33
"""Height of the head's top above eyes and ears, and above the shoulders of an upright person, m."""
NOSE_DOWN = 0.25
"""Angle of the line from the ears to the nose below the direction of the face, rad."""
UNKNOWN = np.pi / np.sqrt(3)
"""Sigma of an angle of which nothing is known, rad."""


ACROSS = ("shoulder", "hip")
"""Joints whose line from right to left tells the heading."""


def tell_heading(joints: Collection[str]) -> bool:
    """Whether there are joints of these names of which a heading follows."""
    return any({f"left_{pair}", f"right_{pair}"} <= set(joints) for pair in ACROSS)


@dataclass(frozen=True, eq=False)
class BodyPoses:
    """Of M people, as in `followspot.people.Poses`: pose and sigma (M, 6)."""

    pose: Array
    sigma: Array


def poses_of(joints: tuple[str, ...], xyz: Array, sigma: Array) -> BodyPoses:
    """Poses from joints. xyz: (M, J, 3) m, NaN for joints whose place is not known; sigma: (M, J) m.

    The heading is across the line of the shoulders and that of the hips; head pan and tilt are those of the
    line from the ears to the nose. What the joints do not tell is 0 with the sigma of an unknown angle.
    """
    body = _Joints(joints, xyz, sigma)
    shoulders, hips, head = body.mean("shoulder", "neck"), body.mean("hip"), body.mean("eye", "ear", "nose")
    every = body.mean("")
    middle = _first(_mean(shoulders, hips), shoulders, hips, every)
    top = _first(head[:, 2] + EYES_UP, shoulders[:, 2] + SHOULDERS_UP, body.highest())
    heading, heading_sigma = body.heading(*ACROSS)
    face, tilt, face_sigma = body.face()
    pan = wrap(face - heading)
    known = np.isfinite(pan)
    pose = np.column_stack([middle[:, :2], top, heading, pan, tilt])
    place = body.usual_sigma()
    head_sigma = np.where(known, np.hypot(face_sigma, heading_sigma), UNKNOWN)
    angles = [heading_sigma, head_sigma, np.where(np.isfinite(tilt), face_sigma, UNKNOWN)]
    found = np.column_stack([place, place, place, *angles])
    return BodyPoses(np.where(np.isfinite(pose), pose, 0.0), np.where(np.isfinite(found), found, UNKNOWN))


@dataclass(frozen=True, eq=False)
class _Joints:
    names: tuple[str, ...]
    xyz: Array
    sigma: Array

    def mean(self, *words: str) -> Array:
        """Mean of the known joints whose names contain one of the words, (M, 3)."""
        rows = [row for row, name in enumerate(self.names) if any(word in name for word in words)]
        return _mean(*(self.xyz[:, row] for row in rows)) if rows else np.full((len(self.xyz), 3), np.nan)

    def one(self, name: str) -> Array:
        """The joint of that name, (M, 3)."""
        return self.mean_of([row for row, own in enumerate(self.names) if own == name])

    def mean_of(self, rows: list[int]) -> Array:
        """Mean of these joints."""
        return _mean(*(self.xyz[:, row] for row in rows)) if rows else np.full((len(self.xyz), 3), np.nan)

    def highest(self) -> Array:
        """Height of the highest known joint, (M,) m."""
        z = np.where(np.isfinite(self.xyz[..., 2]), self.xyz[..., 2], -np.inf).max(axis=1, initial=-np.inf)
        return np.where(np.isfinite(z), z, np.nan)

    def usual_sigma(self) -> Array:
        """Median sigma of the known joints, (M,) m."""
        known = np.where(np.isfinite(self.xyz[..., 0]), self.sigma, np.inf)
        known.sort(axis=1)
        number = np.isfinite(known).sum(axis=1)
        row = np.maximum(number - 1, 0) // 2
        return known[np.arange(len(known)), row] if known.shape[1] else np.full(len(known), np.nan)

    def heading(self, *pairs: str) -> tuple[Array, Array]:
        """Direction across the lines from right to left joints, (M,) rad, and its sigma."""
        across = [self.one(f"left_{pair}") - self.one(f"right_{pair}") for pair in pairs]
        total = np.nansum(np.stack(across), axis=0)[:, :2]
        length = np.hypot(*total.T)
        known = np.isfinite(np.stack(across)).all(axis=-1).any(axis=0) & (length > 0)
        angle = wrap(np.arctan2(total[:, 1], total[:, 0]) - np.pi / 2)
        sigma = np.minimum(np.sqrt(2) * self.usual_sigma() / np.maximum(length, 1e-6), UNKNOWN)
        return np.where(known, angle, np.nan), np.where(known, sigma, UNKNOWN)

    def face(self) -> tuple[Array, Array, Array]:
        """Direction and tilt of the face, rad, and their sigma, (M,) each."""
        ears, nose = self.mean("ear"), self.one("nose")
        ears = _first(ears, self.mean("eye"))
        ahead = nose - ears
        level = np.hypot(ahead[:, 0], ahead[:, 1])
        sigma = np.minimum(self.usual_sigma() / np.maximum(np.linalg.norm(ahead, axis=1), 1e-6), UNKNOWN)
        tilt = np.arctan2(ahead[:, 2], level) + NOSE_DOWN
        return np.arctan2(ahead[:, 1], ahead[:, 0]), tilt, sigma


def _mean(*parts: Array) -> Array:
    """Mean of those that are known, row by row; NaN if none is."""
    stacked = np.stack(parts)
    known = np.isfinite(stacked)
    number = known.sum(axis=0)
    total = np.where(known, stacked, 0.0).sum(axis=0)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _first(*choices: Array) -> Array:
    """The first that is known, row by row."""
    found = choices[0]
    for other in choices[1:]:
        found = np.where(np.isfinite(found), found, other)
    return np.asarray(found)

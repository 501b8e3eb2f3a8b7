"""Bodies that were tracked with left and right reversed, as the labels over time and the face tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Array
from followspot_persons.associate.joints.sides import Sides
from followspot_persons.associate.joints.tracks import JOINT_FIELDS, JointTracks

REVERSED = 1.5
"""Log-odds from which both sides of a part are taken for each other."""
FACE = 8.0
"""Log-odds that a certain face gives at most: a head turns by less than a right angle against the chest."""


def righted(tracks: JointTracks, joints: tuple[str, ...], sides: Sides) -> JointTracks:
    """The bodies, of which parts that are probably reversed get their sides right."""
    if not (tracks.reversal + FACE > REVERSED).any():
        return tracks
    turned = tracks.reversal - FACE * agreement(tracks, joints, sides) > REVERSED
    if not turned.any():
        return tracks
    bodies, other = turned @ sides.part.T > 0, {}
    for name in JOINT_FIELDS:
        values = getattr(tracks, name)
        rows = bodies.reshape(*bodies.shape, *(1,) * (values.ndim - 2))
        other[name] = np.where(rows, values[:, sides.mirror], values)
    exchanged = np.where(turned[:, None, :, None], tracks.exchanged[..., ::-1], tracks.exchanged)
    reversal = np.where(turned, -tracks.reversal, tracks.reversal)
    return replace(tracks, exchanged=exchanged, reversal=reversal, **other)


def agreement(tracks: JointTracks, joints: tuple[str, ...], sides: Sides) -> Array:
    """Agreement of each part with the face, (M, G): cosine of the angle, seen from above, between the line
    from its right to its left joints and the left of the face; nearer to 0, the less certain the face is.
    """
    if not {"nose", "left_ear", "right_ear"} <= set(joints):
        return np.zeros(tracks.reversal.shape)
    head = [joints.index(name) for name in ("nose", "left_ear", "right_ear")]
    nose, *ears = (tracks.xyz[:, row, :2] for row in head)
    ahead = nose - np.mean(ears, axis=0)
    length = np.hypot(*ahead.T)
    variance = tracks.position_covariance[:, head][..., [0, 1], [0, 1]].sum(axis=-1).mean(axis=-1)
    certain = tracks.known[:, head].all(axis=1) * length / np.maximum(length**2 + variance, 1e-9)
    across = (tracks.xyz - tracks.xyz[:, sides.mirror])[..., :2] * (tracks.known * sides.left)[..., None]
    along = (ahead[:, None, 0] * across[..., 1] - ahead[:, None, 1] * across[..., 0]) @ sides.part
    return np.asarray(certain[:, None] * along / np.maximum(np.hypot(*across.T).T @ sides.part, 1e-9))

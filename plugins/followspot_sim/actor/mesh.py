"""Meshes of tubes: rings of points around a bent axis, each ring held by one or two bones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of quadrilaterals that bones move.

    vertex: (V, 3) m, in the rest pose; bone: (V, 2) the two bones that hold a vertex; weight: (V,) share of
    the first; face: (F, 4) vertices, counter-clockwise seen from outside.
    """

    vertex: Array
    bone: Array
    weight: Array
    face: Array

    def centre(self) -> Array:
        """Middle of each face in the rest pose, (F, 3) m."""
        return np.asarray(self.vertex[self.face].mean(axis=1))


@dataclass(frozen=True, eq=False)
class Tube:
    """Rings of a tube from bottom to top, one row each.

    z: (N,) m; middle: (N, 2) x and y of the axis, m; half: (N, 3) width to each side, depth to the front
    and to the back, m; bone: (N, 2); weight: (N,).
    """

    z: Array
    middle: Array
    half: Array
    bone: Array
    weight: Array


def tube(
    keys: Sequence[Sequence[float]],
    bones: Sequence[int],
    joints: Sequence[tuple[float, float]],
    rings: int,
) -> Tube:
    """A smooth tube through key rings.

    keys: rows of z, x, y, half width, half depth to the front, half depth to the back, from bottom to top, m;
    bones: that hold it, the lowest first; joints: the heights between which one bone gives way to the next,
    m; rings: how many rings to make.
    """
    key = np.array(keys, float)
    z = np.linspace(key[0, 0], key[-1, 0], rings)
    rows = np.column_stack([np.interp(z, key[:, 0], column) for column in key.T[1:]])
    rows[1:-1] = (rows[:-2] + 2 * rows[1:-1] + rows[2:]) / 4  # keys are corners; bodies have none
    begin, end = np.array([(-1.0, 0.0), *joints]).T
    at = np.searchsorted(begin, z, side="right") - 1
    share = np.clip((end[at] - z) / (end[at] - begin[at]), 0.0, 1.0)
    chain = np.array([bones[0], *bones])
    return Tube(z, rows[:, :2], rows[:, 2:], np.stack([chain[at], chain[at + 1]], axis=1), share)


def wrap(shape: Tube, around: int, roundness: float = 1.0) -> Mesh:
    """The surface of a tube, with `around` faces to a ring, closed at both ends.

    roundness: 1 for ellipses, less for sections with corners (superellipses with exponent 2 / roundness).
    """
    angle = 2 * np.pi * np.arange(around) / around
    c, s = (np.sign(v) * np.abs(v) ** roundness for v in (np.cos(angle), np.sin(angle)))
    depth = np.where(c > 0, shape.half[:, 1:2], shape.half[:, 2:3])
    x, y = shape.middle[:, :1] + depth * c, shape.middle[:, 1:] + shape.half[:, :1] * s
    z = np.broadcast_to(shape.z[:, None], x.shape)
    rings = len(shape.z)
    ends = np.column_stack([shape.middle[[0, -1]], shape.z[[0, -1]]])
    vertex = np.concatenate([np.stack([x, y, z], axis=2).reshape(-1, 3), ends])
    each = np.concatenate([np.repeat(np.arange(rings), around), [0, rings - 1]])
    return Mesh(vertex, shape.bone[each], shape.weight[each], _faces(rings, around))


def _faces(rings: int, around: int) -> Array:
    """Faces between neighbouring rings, then fans to the two end points."""
    here, right = np.arange(around), np.roll(np.arange(around), -1)
    low = around * np.arange(rings - 1)[:, None]
    sides = np.stack([low + here, low + right, low + around + right, low + around + here], axis=2)
    foot, tip = np.full(around, rings * around), np.full(around, rings * around + 1)
    top = around * (rings - 1)
    lids = [
        np.stack([foot, right, here, here], axis=1),
        np.stack([tip, top + here, top + right, top + right], axis=1),
    ]
    return np.concatenate([sides.reshape(-1, 4), *lids])


def join(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    first = np.cumsum([0] + [len(m.vertex) for m in meshes[:-1]])
    return Mesh(
        np.concatenate([m.vertex for m in meshes]),
        np.concatenate([m.bone for m in meshes]),
        np.concatenate([m.weight for m in meshes]),
        np.concatenate([m.face + k for m, k in zip(meshes, first, strict=True)]),
    )

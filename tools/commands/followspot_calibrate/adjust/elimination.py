"""Normal equations of an adjustment, solved by eliminating the points (the Schur complement).

Points are independent of each other given the cameras, except for those that rods connect. So only a
system of the size of the cameras is dense (H&Z, appendix 6.3; Triggs et al. 2000, section 6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_calibrate.adjust.rods import Group


@dataclass(frozen=True, eq=False)
class Normal:
    """J^T W J and -J^T W r in blocks, for C cameras of P parameters and N points.

    cameras: (C, P, P); points: (N, 3, 3); mixed: (N, 3, C P); rods: (S, 3, 3), the block between the ends of
    a rod; toward_cameras: (C, P) and toward_points: (N, 3), the right-hand side.
    """

    cameras: Array
    points: Array
    mixed: Array
    rods: Array
    toward_cameras: Array
    toward_points: Array

    @classmethod
    def zeros(cls, cameras: int, parameters: int, points: int, rods: int) -> Normal:
        """Nothing summed yet."""
        return cls(
            np.zeros((cameras, parameters, parameters)),
            np.zeros((points, 3, 3)),
            np.zeros((points, 3, cameras * parameters)),
            np.zeros((rods, 3, 3)),
            np.zeros((cameras, parameters)),
            np.zeros((points, 3)),
        )

    def solve(self, groups: Sequence[Group], damping: float) -> tuple[Array, Array]:
        """The damped step of all cameras, (C, P), and points, (N, 3).

        Raises numpy.linalg.LinAlgError if the damping is too small for what the data determine.
        """
        count, size = self.toward_cameras.shape
        blocks = np.zeros((count, size, count, size))
        each = np.arange(count)
        blocks[each, :, each] = _damped(self.cameras, damping)
        dense = blocks.reshape(count * size, count * size)
        toward = self.toward_cameras.ravel().copy()
        points = _damped(self.points, damping)
        eliminated = [self._eliminate(group, points) for group in groups]
        for _, tied, aim in eliminated:
            flat = tied.reshape(aim.size, count * size)
            dense -= flat.T @ flat
            toward -= flat.T @ aim.ravel()
        lower = np.linalg.cholesky(dense)
        step = np.linalg.solve(lower.T, np.linalg.solve(lower, toward))
        shift = np.empty_like(self.toward_points)
        for group, (inverse, tied, aim) in zip(groups, eliminated, strict=True):
            solved = (inverse.swapaxes(1, 2) @ (aim - tied @ step)[..., None])[..., 0]
            shift[group.members] = solved.reshape(*group.members.shape, 3)
        return step.reshape(count, size), shift

    def _eliminate(self, group: Group, points: Array) -> tuple[Array, Array, Array]:
        """L^-1, L^-1 mixed and L^-1 toward of each set, with L L^T its block of points: (G, 3g, ...)."""
        sets, size = group.members.shape
        block = np.zeros((sets, size, 3, size, 3))
        each = np.arange(size)
        block[:, each, :, each] = points[group.members].swapaxes(0, 1)
        which, first, second = group.where
        np.add.at(block.swapaxes(2, 3), (which, first, second), self.rods[group.rods])
        np.add.at(block.swapaxes(2, 3), (which, second, first), self.rods[group.rods])
        inverse = np.linalg.inv(np.linalg.cholesky(block.reshape(sets, size * 3, size * 3)))
        tied = inverse @ self.mixed[group.members].reshape(sets, size * 3, self.mixed.shape[2])
        aim = inverse @ self.toward_points[group.members].reshape(sets, size * 3, 1)
        return inverse, tied, aim[..., 0]


def _damped(blocks: Array, damping: float) -> Array:
    """Diagonals grow by the damping (Marquardt); what no observation touches stays in place."""
    damped = blocks.copy()
    each = np.arange(blocks.shape[1])
    diagonal = blocks[:, each, each]
    damped[:, each, each] = np.where(diagonal > 0, diagonal * (1 + damping), 1.0)
    return damped

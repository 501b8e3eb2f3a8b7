"""Boxes that a network finds in the picture of one camera, of people who hide each other.

A box is the more probable the more of a body nearer people leave visible; often it encloses the visible part
alone. Its edges err, some boxes come twice, and some show nobody.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.people import Boxes

CELL = 8
"""Side of the cells in which bodies hide each other, px."""
LIMB = 0.07
"""Radius of the body about each of its points, m."""
NEAREST = 0.3
"""Smallest distance of a body that has a picture, m."""
SEEN = np.array([0.15, 0.35, 0.6])
"""Visible shares of a body from which it is found with these probabilities, and with 0 below."""
FOUND = np.array([0.0, 0.3, 0.8, 0.97])
LYING = 0.75
"""Factor of the probability for a body that lies."""
WHOLE, PARTIAL = 0.9, 0.6
"""Share of a body below which its box may enclose the visible part alone, and how often it does."""
BIAS, NOISE = 0.02, 0.022
"""Sigmas of the edges of a box over its size: the same in all pictures of a camera, and of each picture."""
TWICE, LOOSE = 0.1, 0.08
"""Share of the boxes that come twice, and sigma of the second one's edges."""
SMALLEST = 8.0
"""Smallest side of a box, px."""


@dataclass(frozen=True, eq=False)
class Network:
    """How a network sees the people in one camera. bias: (N, 4) of the edges of each one's boxes, over the
    size of the box; false: mean number of boxes in a picture that show nobody.
    """

    camera: Camera
    bias: Array
    false: float

    def boxes(self, surface: Array, lying: Array, rng: np.random.Generator) -> Boxes:
        """The boxes of one picture. surface: (N, P, 3) m, points of the bodies; lying: (N,) bool."""
        found: list[tuple[Array, float]] = []
        for number, share, box in self.visible(surface, rng):
            size = 0.8 * np.hypot(*(box[2:] - box[:2]))
            likely = FOUND[np.searchsorted(SEEN, share)] * (LYING if lying[number] else 1.0)
            if rng.random() >= likely:
                continue
            box = box + size * (self.bias[number] + rng.normal(0, NOISE, 4))
            score = np.clip(1 - 0.25 * rng.random() - 0.6 * (1 - share), 0.31, 1.0)
            found.append((box, score))
            if rng.random() < TWICE:
                found.append((box + size * rng.normal(0, LOOSE, 4), 0.3 + 0.4 * rng.random() * score))
        found += self.shows_nobody(rng)
        box = np.array([one for one, _ in found]).reshape(-1, 4)
        box = np.clip(box, 0, np.tile(np.array(self.camera.size) - 1.0, 2))
        large = ((box[:, 2:] - box[:, :2]) >= SMALLEST).all(axis=1)
        none = np.zeros((int(large.sum()), 0))
        return Boxes(self.camera.name, box[large], np.array([s for _, s in found])[large], none, none)

    def visible(self, surface: Array, rng: np.random.Generator) -> list[tuple[int, float, Array]]:
        """Of each body in the picture its number, the share that is visible, and the box about it, px."""
        camera = self.camera
        local = surface @ camera.rotation.T + camera.translation
        front = np.flatnonzero((local[..., 2] > NEAREST).all(axis=1))
        depth = np.median(local[..., 2], axis=1)
        width, height = camera.size
        covered = np.zeros((height // CELL, width // CELL), bool)
        found = []
        for number in front[np.argsort(depth[front], kind="stable")]:
            image = local[number] @ camera.matrix.T
            uv = image[:, :2] / image[:, 2:]
            cells, inside = outline(uv, covered.shape, LIMB * camera.matrix[0, 0] / depth[number] / CELL)
            shown = cells & ~covered
            covered |= cells
            share = shown.sum() / max(cells.sum(), 1) * min(1.0, inside / WHOLE)
            box = np.concatenate([uv.min(axis=0), uv.max(axis=0)])
            if shown.any() and share < WHOLE and rng.random() < PARTIAL:
                box = np.array(
                    [*np.maximum(box[:2], extent(shown)[:2]), *np.minimum(box[2:], extent(shown)[2:])]
                )
            found.append((int(number), float(share), box))
        return found

    def shows_nobody(self, rng: np.random.Generator) -> list[tuple[Array, float]]:
        """Boxes of nobody, anywhere, with their scores."""
        found = []
        for _ in range(rng.poisson(self.false)):
            middle, half = rng.uniform(0, self.camera.size), rng.uniform(20, 80, 2) * (1, 1.6)
            found.append((np.concatenate([middle - half, middle + half]), rng.uniform(0.3, 0.7)))
        return found


def network(camera: Camera, people: int, false: float, rng: np.random.Generator) -> Network:
    """A network with errors of its own for each of so many people."""
    return Network(camera, rng.normal(0, BIAS, (people, 4)), false)


def outline(uv: Array, shape: tuple[int, ...], radius: float) -> tuple[Array, float]:
    """The cells that a body covers, bool of that shape, and the share of its points in the picture.

    uv: (P, 2) px, its points; radius: about each, cells.
    """
    reach = max(1, round(radius))
    cell = np.floor(uv / CELL).astype(int)
    inside = ((cell >= 0) & (cell < shape[::-1])).all(axis=1)
    column, row = cell[inside].T
    covered = np.zeros((shape[0] + 2 * reach, shape[1] + 2 * reach), bool)
    for down in range(2 * reach + 1):
        for right in range(2 * reach + 1):
            covered[row + down, column + right] = True
    return covered[reach:-reach, reach:-reach], float(inside.mean())


def extent(cells: Array) -> Array:
    """The box about some cells and one more on each side, (4,) px."""
    row, column = cells.nonzero()
    low, high = np.array([column.min(), row.min()]) - 1, np.array([column.max(), row.max()]) + 2
    return np.asarray(np.concatenate([low, high]) * CELL, float)

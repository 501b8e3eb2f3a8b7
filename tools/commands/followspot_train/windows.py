"""Windows to learn from: persons as a search meets them, near misses, and backgrounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.cells import cell_features
from followspot_persons.hog.channels import channels
from followspot_persons.hog.window import BODY, HEIGHT, TALL, WIDTH, cut, describe
from followspot_train.pictures import Background, Person

PLACE_SIGMA, SIZE_SIGMA = 2.5 / TALL, 0.06
"""Standard deviations of a search: place over the height of the box, logarithm of the size."""
MISS = (0.22, 0.4)
"""Range of a near miss, over the height of the box."""
BLUR = (0.5, 1.5)
"""Range of the blur that some windows get, px."""
CUT = 0.15
"""Share of the persons' windows that reach over the top of the picture, if they may."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Described windows; all rows of one person carry its number."""

    features: Array
    """(N, FEATURES) for the linear detector."""
    cell_features: Array
    """(N, CELL_FEATURES), inputs of the network."""
    channels: Array
    """(N, CHANNELS) f2, inputs of the trees, after the features of cells."""
    owner: Array
    """(N,) number of the person; -1 for backgrounds."""
    torso: Array
    """(N,) rad, NaN if unknown."""
    head: Array

    def where(self, rows: Array) -> Windows:
        """Only these rows: a mask or numbers."""
        return Windows(*(array[rows] for array in vars(self).values()))


def described(windows: Sequence[Array], owner: Sequence[int], headings: Array) -> Windows:
    """Windows (HEIGHT, WIDTH, 3) u8 with owners and headings (N, 2) of torso and head, rad."""
    angles = np.reshape(headings, (-1, 2)).astype(float)
    inputs = describe(windows), cell_features(windows), channels(windows).astype(np.float16)
    return Windows(*inputs, np.array(owner, int), angles[:, 0], angles[:, 1])


def exact(persons: Sequence[Person]) -> Windows:
    """Each person once, as the data set has it."""
    windows = [cut(person.pixels, person.box) for person in persons]
    return described(windows, range(len(persons)), np.array([(p.torso, p.head) for p in persons]))


def found(persons: Sequence[Person], count: int, above: int, rng: np.random.Generator) -> Windows:
    """Each person `count` times at the places and sizes of a search, relit, half of them mirrored.

    above: most rows of a window that may lie above the picture.
    """
    windows, owner, headings = [], [], []
    for number, person in enumerate(persons):
        for _ in range(count):
            window, sign = mirrored(cut(person.pixels, as_found(person.box, rng)), rng)
            window = relit(window, rng)
            if above and rng.random() < CUT:
                window = reaching_over(window, int(rng.integers(1, above + 1)))
            windows.append(window)
            owner.append(number)
            headings.append((sign * person.torso, sign * person.head))
    return described(windows, owner, np.array(headings))


def missed(persons: Sequence[Person], count: int, rng: np.random.Generator) -> Windows:
    """Each person `count` times, but beside it, or too near or too far: no upper body in its place."""
    windows, owner = [], []
    for number, person in enumerate(persons):
        for _ in range(count):
            windows.append(cut(person.pixels, as_missed(person.box, rng)))
            owner.append(number)
    return described(windows, owner, np.full((len(windows), 2), np.nan))


def as_found(box: Array, rng: np.random.Generator) -> Array:
    """A box as a search finds it."""
    moved = rng.normal(0, PLACE_SIGMA, 2)
    return _moved(box, moved, np.exp(rng.normal(0, SIZE_SIGMA)))


def as_missed(box: Array, rng: np.random.Generator) -> Array:
    """A box beside the true one, or of another size."""
    angle, far = rng.uniform(0, 2 * np.pi), rng.uniform(*MISS)
    by, size = far * np.array([np.cos(angle), np.sin(angle)]), 1.0
    if rng.random() < 0.4:
        by, size = by / 4, np.exp(rng.choice([-1, 1]) * rng.uniform(0.3, 0.5))
    return _moved(box, by, size)


def mirrored(window: Array, rng: np.random.Generator) -> tuple[Array, int]:
    """A window, one in two of them mirrored; 1, or -1 for a mirrored one."""
    sign = 1 if rng.random() < 0.5 else -1
    return np.ascontiguousarray(window[:, ::sign]), sign


def anywhere(backgrounds: Sequence[Background], count: int, rng: np.random.Generator) -> list[Array]:
    """Windows of any place and size in pictures without people."""
    windows = []
    for _ in range(count):
        pixels = backgrounds[int(rng.integers(len(backgrounds)))].pixels
        height, width = pixels.shape[:2]
        scale = np.exp(rng.uniform(np.log(0.45), np.log(0.95 * min(height / HEIGHT, width / WIDTH))))
        corner = rng.uniform(0, [width - WIDTH * scale, height - HEIGHT * scale])
        windows.append(cut(pixels, BODY * scale + np.tile(corner, 2)))
    return windows


def reaching_over(window: Array, rows: int) -> Array:
    """A window (HEIGHT, WIDTH, 3) whose first rows are above the picture, where the border is repeated."""
    out = window.copy()
    out[:rows] = window[rows]
    return out


def _moved(box: Array, by: Array, size: float) -> Array:
    """A box moved by a share of its height, and of another size."""
    tall = box[3] - box[1]
    center = (box[:2] + box[2:]) / 2 + by * tall
    half = (box[2:] - box[:2]) / 2 * size
    return np.concatenate([center - half, center + half])


def relit(window: Array, rng: np.random.Generator) -> Array:
    """Another exposure, white balance, contrast and noise; sometimes out of focus."""
    gain = np.exp(rng.normal(0, 0.12, 3) + rng.normal(0, 0.2))
    light = 255 * gain * (window / 255) ** np.exp(rng.normal(0, 0.15))
    light += rng.normal(0, rng.uniform(0, 5), window.shape)
    if rng.random() < 0.3:
        light = np.asarray(cv2.GaussianBlur(light, (0, 0), rng.uniform(*BLUR)))
    return np.asarray(np.clip(light, 0, 255), np.uint8)

"""The proposing detector: a linear classifier, trained with the backgrounds that deceive it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.window import BODY, HEIGHT, STRIDE, WIDTH, describe, descriptor
from followspot_train import svm
from followspot_train.pictures import Background
from followspot_train.windows import anywhere

COST = 0.003
ROUNDS = 3
"""Times that the backgrounds are searched for windows that deceive the detector of the round before."""
FIRST = 6000
"""Windows anywhere, to begin with."""
HARD = 5000
"""Most windows that one round adds."""
EACH = 40
"""Most of them from one background in one size."""
PASSING = 0.99
"""Share of the persons' windows that the detector must propose."""
SPARE = 0.4
"""By how much the finished detector passes what is below its bar of learning, for legs may tell a person."""
SIZES = (0.4, 2.2)
"""Smallest and largest scale of a background."""
STEP = 1.15


class Seen(NamedTuple):
    """A window of a background, and what the detector says of it."""

    score: float
    window: Array


def train(
    persons: Array,
    backgrounds: Sequence[Background],
    above: int,
    rng: np.random.Generator,
    report_progress: Callable[[str], None],
) -> tuple[Array, list[Array]]:
    """Weights (FEATURES + 1,), bias last, and the background windows that they were trained with.

    persons: (N, FEATURES); above: of :func:`sizes`; report_progress: called with a line.
    """
    windows = anywhere(backgrounds, FIRST, rng)
    negatives = describe(windows)
    weights = _fitted(persons, negatives, rng)
    for number in range(ROUNDS):
        report_progress(f"searching backgrounds for what deceives, {number + 1} of {ROUNDS}")
        seen = [s for picture in backgrounds for s in hardest(picture.pixels, weights, -0.5, above)]
        seen.sort(key=lambda s: -s.score)
        hard = [s.window for s in seen[:HARD]]
        windows += hard
        negatives = np.vstack([negatives, describe(hard)])
        weights = _fitted(persons, negatives, rng)
    weights[-1] -= np.quantile(persons @ weights[:-1] + weights[-1], 1 - PASSING)
    return weights, windows


def finished(weights: Array) -> Array:
    """The weights of the detector in use, which passes more than it learnt with: (FEATURES + 1,)."""
    return _moved(weights, SPARE)


def learning(weights: Array) -> Array:
    """The inverse of :func:`finished`: at this bar, what passes deceives."""
    return _moved(weights, -SPARE)


def _moved(weights: Array, by: float) -> Array:
    moved = weights.copy()
    moved[-1] += by
    return moved


def _fitted(persons: Array, negatives: Array, rng: np.random.Generator) -> Array:
    X = np.vstack([persons, negatives])
    X = np.hstack([X, np.ones((len(X), 1), np.float32)])
    sign = np.repeat([1.0, -1.0], [len(persons), len(negatives)])
    cost = np.repeat([COST * len(negatives) / len(persons), COST], [len(persons), len(negatives)])
    return svm.fit(X, sign, cost, rng)


def hardest(pixels: Array, weights: Array, least: float, above: int) -> list[Seen]:
    """The best windows of each size, with scores above the least."""
    seen = []
    for picture in sizes(pixels, above=above):
        corners, scores = _detected(picture, weights, least)
        for row in np.argsort(-scores)[:EACH]:
            x, y = corners[row]
            seen.append(Seen(float(scores[row]), picture[y : y + HEIGHT, x : x + WIDTH].copy()))
    return seen


def passing(pixels: Array, weights: Array, above: int) -> tuple[Array, int]:
    """All windows that the detector proposes, (N, HEIGHT, WIDTH, 3) u8, and the number that it searched."""
    windows, count = [], 0
    for picture in sizes(pixels, above=above):
        count += _count(picture)
        corners, _ = _detected(picture, weights, 0.0)
        windows += [picture[y : y + HEIGHT, x : x + WIDTH] for x, y in corners]
    return np.reshape(windows, (-1, HEIGHT, WIDTH, 3)).astype(np.uint8), count


def places(pixels: Array, weights: Array) -> Array:
    """Boxes (N, 4) of upper bodies that the detector proposes, px of the picture."""
    found = [np.empty((0, 4))]
    for picture in sizes(pixels):
        scale = np.array(picture.shape[1::-1]) / pixels.shape[1::-1]
        corners, _ = _detected(picture, weights, 0.0)
        found.append((np.tile(corners, 2) + BODY) / np.tile(scale, 2))
    return np.concatenate(found)


def searched(pixels: Array) -> int:
    """The number of windows of a picture."""
    return sum(_count(picture) for picture in sizes(pixels))


def _count(picture: Array) -> int:
    height, width = picture.shape[:2]
    return int(((width - WIDTH) // STRIDE + 1) * ((height - HEIGHT) // STRIDE + 1))


def sizes(pixels: Array, window: tuple[int, int] = (WIDTH, HEIGHT), above: int = 0) -> Iterator[Array]:
    """The picture in all sizes that hold a window, largest first, with its border repeated `above` times
    over the top.
    """
    height, width = pixels.shape[:2]
    scale = SIZES[1]
    while scale >= max(SIZES[0], window[1] / height, window[0] / width):
        size = (int(width * scale), int(height * scale))
        kind = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        resized = cv2.resize(pixels, size, interpolation=kind)
        yield np.asarray(cv2.copyMakeBorder(resized, above, 0, 0, 0, cv2.BORDER_REPLICATE))
        scale /= STEP


def _detected(picture: Array, weights: Array, least: float) -> tuple[Array, Array]:
    hog = descriptor()
    hog.setSVMDetector(weights)
    corners, scores = hog.detect(picture, least, (STRIDE, STRIDE), (0, 0))
    return np.reshape(corners, (-1, 2)).astype(int), np.ravel(scores)

"""The judging network: one hidden layer, trained with Adam (Kingma & Ba 2015), dropout and weight decay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.hog.model import DIRECTIONS
from followspot_persons.hog.network import Network

UNITS = 64
EPOCHS = 10
BATCH = 128
RATE = 1e-3
DECAY = 1e-2
"""Weight decay, over the learning rate."""
DROPPED_INPUT, DROPPED_UNITS = 0.2, 0.4
SHARPNESS = 6.0
"""Concentration of the true directions, so that neighbours of the true one count too."""
ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS


@dataclass(frozen=True, eq=False)
class Examples:
    """Inputs (N, D) f4 or f2 and the targets of the network."""

    inputs: Array
    person: Array
    """(N,) 1 or 0."""
    parts: tuple[Array, ...] = ()
    """Of each part of the body whose direction is learnt: (N, DIRECTIONS) shares, all 0 if unknown."""


def directions(angle: Array) -> Array:
    """Shares of directions around angles (N,), rad; all 0 if the angle is NaN: (N, DIRECTIONS) f4."""
    share = np.exp(SHARPNESS * (np.cos(angle[:, None] - ANGLES) - 1))
    share /= share.sum(axis=1, keepdims=True)
    return np.nan_to_num(share).astype(np.float32)


def train(
    examples: Examples,
    rng: np.random.Generator,
    report_progress: Callable[[str], None],
    units: int = UNITS,
) -> Network:
    """A network that was trained on the examples: whether a person is there, and directions of the parts."""
    count, inputs = examples.inputs.shape
    mean = examples.inputs.mean(axis=0, dtype=np.float32)
    spread = examples.inputs.std(axis=0, dtype=np.float32) + np.float32(1e-3)
    outputs = 1 + DIRECTIONS * len(examples.parts)
    weights = [
        rng.normal(0, 1 / np.sqrt(inputs), (inputs, units)).astype(np.float32),
        np.zeros(units, np.float32),
        rng.normal(0, 0.5 / np.sqrt(units), (units, outputs)).astype(np.float32),
        np.zeros(outputs, np.float32),
    ]
    weights[3][0] = np.log((examples.person.sum() + 1) / ((1 - examples.person).sum() + 1))
    adam = Adam(weights, EPOCHS * (count // BATCH))
    for epoch in range(EPOCHS):
        report_progress(f"training the network, {epoch + 1} of {EPOCHS}")
        order = rng.permutation(count)
        for start in range(0, count - BATCH + 1, BATCH):
            rows = order[start : start + BATCH]
            x = (examples.inputs[rows] - mean) / spread
            adam.step(gradients(weights, x, examples.person[rows], [p[rows] for p in examples.parts], rng))
    first = weights[0] / spread[:, None]
    return Network(first, weights[1] - mean @ first, weights[2], weights[3])


def gradients(
    weights: list[Array], x: Array, person: Array, parts: Sequence[Array], rng: np.random.Generator
) -> list[Array]:
    """Gradient of the mean cross entropy of person and directions, with dropout of inputs and units."""
    x = x * _kept(x.shape, DROPPED_INPUT, rng)
    hidden = x @ weights[0] + weights[1]
    mask = (hidden > 0) * _kept(hidden.shape, DROPPED_UNITS, rng)
    active = hidden * mask
    wrong = errors(active @ weights[2] + weights[3], person, parts) / np.float32(len(x))
    back = (wrong @ weights[2].T) * mask
    return [x.T @ back, back.sum(axis=0), active.T @ wrong, wrong.sum(axis=0)]


def errors(out: Array, person: Array, parts: Sequence[Array]) -> Array:
    """Derivative of the cross entropies by the outputs: what was said less what is true, (N, outputs)."""
    wrong = np.empty_like(out)
    wrong[:, 0] = np.exp(-np.logaddexp(0, -out[:, 0])) - person
    for number, true in enumerate(parts):
        part = slice(1 + DIRECTIONS * number, 1 + DIRECTIONS * (number + 1))
        share = np.exp(out[:, part] - out[:, part].max(axis=1, keepdims=True))
        share /= share.sum(axis=1, keepdims=True)
        wrong[:, part] = share * true.sum(axis=1, keepdims=True) - true
    return wrong


def _kept(shape: tuple[int, ...], dropped: float, rng: np.random.Generator) -> Array:
    return (rng.random(shape, np.float32) > dropped) / np.float32(1 - dropped)


class Adam:
    """Moves weights, in place, against their gradients; the rate falls to nothing at the last step."""

    def __init__(self, weights: list[Array], steps: int) -> None:
        self.weights, self.steps, self.done = weights, steps, 0
        self.mean = [np.zeros_like(w) for w in weights]
        self.square = [np.zeros_like(w) for w in weights]

    def step(self, slopes: list[Array], fast: float = 0.9, slow: float = 0.99) -> None:
        self.done += 1
        rate = RATE * max(0.01, 1 - self.done / self.steps)
        for w, slope, mean, square in zip(self.weights, slopes, self.mean, self.square, strict=True):
            mean += (1 - fast) * (slope - mean)
            square += (1 - slow) * (slope * slope - square)
            size = np.sqrt(square / (1 - slow**self.done)) + 1e-6
            w -= rate * (mean / (1 - fast**self.done) / size)
            if w.ndim == 2:  # biases do not decay
                w -= rate * DECAY * w

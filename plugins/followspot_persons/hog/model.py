"""Trained weights: a linear detector that proposes windows, a small network and trees that classify them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.array_files import read_arrays
from followspot.errors import InputError, Mistake
from followspot_persons.hog.cells import CELL_FEATURES, cell_features
from followspot_persons.hog.channels import CHANNELS, channels
from followspot_persons.hog.network import Network, outputs
from followspot_persons.hog.network import check as check_network
from followspot_persons.hog.trees import Trees, log_odds
from followspot_persons.hog.trees import check as check_trees
from followspot_persons.hog.window import FEATURES

SHIPPED = Path(__file__).with_name("hog_weights.npz")
SHIPPED_ABOVE = Path(__file__).with_name("hog_weights_above.npz")
DIRECTIONS = 16
"""Number of headings with a likelihood; direction i is 2 pi i / 16, 0 faces the camera."""
OUTPUTS = 1 + 2 * DIRECTIONS
UNLIKELY = -6.0
"""Log-odds of the network below which the trees are not evaluated."""
TREES = 0.3
"""Share of the trees in a score: half finds no more people in streets, and more false ones in rooms."""
HEADINGS: Mapping[str, Array] = {
    "heading_hidden": np.zeros((CELL_FEATURES, 0), np.float32),
    "heading_hidden_bias": np.zeros(0, np.float32),
    "heading_output": np.zeros((0, 2 * DIRECTIONS), np.float32),
    "heading_output_bias": np.zeros(2 * DIRECTIONS, np.float32),
}
"""The network of headings that a weights file may lack, without units."""
OPTIONAL: Mapping[str, Array] = {
    "tree_feature": np.zeros((0, 3), np.intp),
    "tree_threshold": np.zeros((0, 3), np.float32),
    "tree_leaf": np.zeros((0, 4), np.float32),
    "calibration": np.array([1.0, 0.0], np.float32),
    **HEADINGS,
}
"""Arrays that a weights file may lack, and their defaults: no trees, scores that are log-odds, and directions
from the network that tells people from backgrounds."""


@dataclass(frozen=True, eq=False)
class HogModel:
    """Weights, f4. `followspot train hog` makes them."""

    linear: Array
    """(FEATURES + 1,) of the proposing detector, the bias last; windows above 0 are classified."""
    hidden: Array
    """(CELL_FEATURES, K) first layer of the network."""
    hidden_bias: Array
    """(K,)"""
    output: Array
    """(K, OUTPUTS) second layer: upper body or not, directions of the torso, directions of the head."""
    output_bias: Array
    """(OUTPUTS,)"""
    trust: Array
    """(2, 2) for torso and head: the factor of the log-likelihoods, and the share of sheer mistakes."""
    tree_feature: Array
    """(T, 3) intp, of features of cells and channels: see :class:`Trees`, as for the next two."""
    tree_threshold: Array
    """(T, 3)"""
    tree_leaf: Array
    """(T, 4)"""
    calibration: Array
    """(2,) factor and offset that make log-odds of the scores of network and trees (Platt 1999)."""
    heading_hidden: Array
    """(CELL_FEATURES, H) first layer of the network of headings; without units, :attr:`network` predicts
    the directions."""
    heading_hidden_bias: Array
    """(H,)"""
    heading_output: Array
    """(H, 2 DIRECTIONS) directions of the torso, directions of the head."""
    heading_output_bias: Array
    """(2 DIRECTIONS,)"""

    @property
    def network(self) -> Network:
        return Network(self.hidden, self.hidden_bias, self.output, self.output_bias)

    @property
    def headings(self) -> Network:
        layers = self.heading_hidden, self.heading_hidden_bias, self.heading_output, self.heading_output_bias
        return Network(*layers)

    @property
    def trees(self) -> Trees:
        return Trees(self.tree_feature, self.tree_threshold, self.tree_leaf)


NAMES = [field.name for field in fields(HogModel) if field.name not in OPTIONAL]
"""Arrays that a weights file must have."""


@dataclass(frozen=True, eq=False)
class Classification:
    """Score and headings of N windows by network and trees."""

    score: Array
    """(N,) log-odds of an upper body, 0 at the threshold."""
    torso: Array
    """(N, DIRECTIONS) log-likelihood."""
    head: Array


def classify(model: HogModel, windows: Array | Sequence[Array]) -> Classification:
    """Score and headings of windows (N, HEIGHT, WIDTH, 3) u8."""
    return classify_features(
        model, cell_features(windows), lambda rows: channels([windows[row] for row in rows])
    )


def classify_features(
    model: HogModel, cell_features: Array, channels: Callable[[Array], Array]
) -> Classification:
    """Score and headings of windows from their features of cells, (N, CELL_FEATURES), and the channels of
    rows of them.

    The score is the calibrated mean of what network and trees say, weighted by `TREES`; where the network
    says that a person is unlikely, or without trees, it is the network's.
    """
    out = outputs(model.network, cell_features).astype(float)
    directions = out[:, 1:]
    if model.heading_hidden.size:
        directions = outputs(model.headings, cell_features).astype(float)
    torso, head = directions[:, :DIRECTIONS], directions[:, DIRECTIONS:]
    score = out[:, 0].copy()
    if len(model.tree_leaf):
        likely = np.flatnonzero(score > UNLIKELY)
        features = np.hstack([cell_features[likely], channels(likely)])
        score[likely] += TREES * (log_odds(model.trees, features) - score[likely])
    factor, offset = model.calibration.astype(float)
    return Classification(
        factor * score + offset, trusted(torso, *model.trust[0]), trusted(head, *model.trust[1])
    )


def joined(parts: Sequence[Classification]) -> Classification:
    """All rows of all parts."""
    return Classification(*(np.concatenate(c) for c in zip(*(vars(p).values() for p in parts), strict=True)))


def trusted(logits: Array, factor: float, mistaken: float) -> Array:
    """Calibrated log-likelihoods of directions, (N, DIRECTIONS).

    factor: of the logits, below 1 if the network is too sure of unknown people; mistaken: share of windows
    with a random direction.
    """
    scaled = factor * logits
    scaled -= scaled.max(axis=1, keepdims=True, initial=-np.inf)
    share = np.exp(scaled)
    share /= share.sum(axis=1, keepdims=True)
    return np.asarray(np.log((1 - mistaken) * share + mistaken / DIRECTIONS))


@cache
def load(path: Path = SHIPPED) -> HogModel:
    """Read a weights file. Raises InputError if it is invalid."""
    try:
        model = HogModel(**_fields(path))
        _check(model)
    except (OSError, ValueError, KeyError) as error:
        remedy = "make one with `followspot train hog`, or leave the parameter out"
        raise InputError([Mistake(None, f"{path} holds no weights of a detector: {error}", remedy)]) from None
    return model


def _fields(path: Path) -> dict[str, Array]:
    """The arrays of a model in a file."""
    stored = read_arrays(path)
    given = {name: stored[name].astype(other.dtype) for name, other in OPTIONAL.items() if name in stored}
    rest = {name: stored[name].astype(np.float32) for name in NAMES}
    return {**OPTIONAL, **given, **rest}


def save(model: HogModel, path: Path) -> None:
    """Write a weights file; half precision is enough for weights, but not for thresholds."""
    half = {name: getattr(model, name).astype(np.float16) for name in (*NAMES, *HEADINGS)}
    rest = {name: other for name, other in OPTIONAL.items() if name not in HEADINGS}
    exact = {name: getattr(model, name).astype(other.dtype) for name, other in rest.items()}
    np.savez_compressed(path, allow_pickle=False, **half, **exact)


def _check(model: HogModel) -> None:
    """Raises ValueError if a shape is wrong or a number is not finite."""
    check_network(model.network, CELL_FEATURES, OUTPUTS)
    check_network(model.headings, CELL_FEATURES, 2 * DIRECTIONS)
    for name, shape in {"linear": (FEATURES + 1,), "trust": (2, 2), "calibration": (2,)}.items():
        array = getattr(model, name)
        if array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}, not {shape}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds numbers that are not finite")
    if model.calibration[0] <= 0:
        raise ValueError("calibration has a factor that is not above 0")
    check_trees(model.trees, CELL_FEATURES + CHANNELS)

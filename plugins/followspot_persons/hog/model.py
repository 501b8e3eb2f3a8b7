"""The trained weights: a linear detector that proposes windows, and a small network that judges them."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.errors import InputError, Mistake
from followspot.files import DATA, open_regular
from followspot_persons.hog.cells import LOOKS
from followspot_persons.hog.window import FEATURES

SHIPPED = Path(__file__).with_name("hog_weights.npz")
SHIPPED_ABOVE = Path(__file__).with_name("hog_weights_above.npz")
DIRECTIONS = 16
"""Number of headings with a likelihood; direction i is 2 pi i / 16, 0 faces the camera."""
OUTPUTS = 1 + 2 * DIRECTIONS


@dataclass(frozen=True, eq=False)
class HogModel:
    """Weights, f4. `followspot train hog` makes them."""

    linear: Array
    """(FEATURES + 1,) of the proposing detector, the bias last; a window above 0 is worth a look."""
    hidden: Array
    """(LOOKS, K) first layer of the network."""
    hidden_bias: Array
    """(K,)"""
    output: Array
    """(K, OUTPUTS) second layer: upper body or not, directions of the torso, directions of the head."""
    output_bias: Array
    """(OUTPUTS,)"""
    trust: Array
    """(2, 2) for torso and head: the factor of the log-likelihoods, and the share of sheer mistakes."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """The network's output for N windows."""

    score: Array
    """(N,) log-odds of an upper body, 0 at the threshold."""
    torso: Array
    """(N, DIRECTIONS) log-likelihood."""
    head: Array


def judge(model: HogModel, looks: Array) -> Judgement:
    """Score and headings of windows, from their looks (N, LOOKS)."""
    hidden = np.maximum(looks @ model.hidden + model.hidden_bias, 0)
    out = (hidden @ model.output + model.output_bias).astype(float)
    torso, head = out[:, 1 : 1 + DIRECTIONS], out[:, 1 + DIRECTIONS :]
    return Judgement(out[:, 0], trusted(torso, *model.trust[0]), trusted(head, *model.trust[1]))


def joined(parts: Sequence[Judgement]) -> Judgement:
    """All rows of all parts."""
    return Judgement(*(np.concatenate(c) for c in zip(*(vars(p).values() for p in parts), strict=True)))


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
        model = HogModel(**_arrays(path))
        _check(model)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        remedy = "make one with `followspot train hog`, or leave the parameter out"
        raise InputError([Mistake(None, f"{path} holds no weights of a detector: {error}", remedy)]) from None
    return model


def _arrays(path: Path) -> dict[str, Array]:
    """The arrays in a file, which may be compressed and has a limit unpacked, too."""
    with open_regular(path, DATA) as file:
        if sum(member.file_size for member in zipfile.ZipFile(file).infolist()) > DATA:
            raise ValueError(f"more than {DATA} bytes unpacked")
        file.seek(0)
        stored = np.load(file, allow_pickle=False)
        return {field.name: stored[field.name].astype(np.float32) for field in fields(HogModel)}


def save(model: HogModel, path: Path) -> None:
    """Write a weights file; half precision is enough for weights."""
    arrays = {field.name: getattr(model, field.name).astype(np.float16) for field in fields(model)}
    np.savez_compressed(path, allow_pickle=False, **arrays)


def _check(model: HogModel) -> None:
    """Raises ValueError if a shape is wrong or a number is not finite."""
    units = model.hidden_bias.size
    shapes = {
        "linear": (FEATURES + 1,),
        "hidden": (LOOKS, units),
        "hidden_bias": (units,),
        "output": (units, OUTPUTS),
        "output_bias": (OUTPUTS,),
        "trust": (2, 2),
    }
    for name, shape in shapes.items():
        array = getattr(model, name)
        if array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}, not {shape}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds numbers that are not finite")

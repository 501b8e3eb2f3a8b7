"""The trained weights that judge whole people: a small network and boosted trees over the same channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.array_files import read_arrays
from followspot.errors import InputError, Mistake
from followspot_persons.hog import network, trees
from followspot_persons.hog.channels import CELL, MAPS, channels
from followspot_persons.hog.network import Network
from followspot_persons.hog.trees import Trees
from followspot_persons.hog.window import Layout

SHIPPED_WHOLE = Path(__file__).with_name("hog_weights_whole.npz")
LAYOUT = Layout(64, 128, 14.0, 44.0)
"""Window of a whole person, standing upright."""
INPUTS = MAPS * (LAYOUT.width // CELL) * (LAYOUT.height // CELL)
"""Number of features of a window."""
TREES = 0.7
"""Share of the trees in the score: the network alone takes more furniture of rooms for people."""


@dataclass(frozen=True, eq=False)
class WholeModel:
    """What tells whole people. `followspot train whole` makes one."""

    network: Network
    """Of INPUTS and one output, the log-odds of a person."""
    trees: Trees


def whole_log_odds(model: WholeModel, windows: Sequence[Array]) -> Array:
    """Log-odds (N,) of a whole person in one or more windows of the size of the layout, (H, W, 3) u8."""
    described = channels(windows)
    alone = network.outputs(model.network, described)[:, 0]
    return np.asarray(alone + TREES * (trees.log_odds(model.trees, described) - alone))


@cache
def load(path: Path = SHIPPED_WHOLE) -> WholeModel:
    """Read a file of weights. Raises InputError if it is invalid."""
    try:
        stored = read_arrays(path)
        feature = stored["tree_feature"].astype(np.intp)
        bounds, leaves = (stored[name].astype(np.float32) for name in ("tree_threshold", "tree_leaf"))
        layers = [stored[field.name].astype(np.float32) for field in fields(Network)]
        model = WholeModel(Network(*layers), Trees(feature, bounds, leaves))
        network.check(model.network, INPUTS, 1)
        trees.check(model.trees, INPUTS)
    except (OSError, ValueError, KeyError) as error:
        remedy = "make one with `followspot train whole`, or leave the parameter out"
        raise InputError([Mistake(None, f"{path} does not tell whole bodies: {error}", remedy)]) from None
    return model


def save(model: WholeModel, path: Path) -> None:
    """Write a file of weights; half precision is enough for those of the network."""
    grown = model.trees
    named = {"tree_feature": grown.feature.astype(np.uint16), "tree_threshold": grown.threshold}
    layers = {name: array.astype(np.float16) for name, array in vars(model.network).items()}
    np.savez_compressed(path, allow_pickle=False, **named, tree_leaf=grown.leaf, **layers)

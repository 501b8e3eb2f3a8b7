"""Tables of tracks and truth of targets, made of positions."""

import numpy as np

from followspot_accuracy import (
    TargetScore,
    TruthTable,
)

FPS = 30.0


def truth(xyz: np.ndarray, **flags: np.ndarray) -> TruthTable:
    """Objects a, b, ... at (F, M, 3); visible everywhere unless told."""
    shape = xyz.shape[:2]
    marks = {
        "hidden": np.zeros(shape, bool),
        "trackable": np.ones(shape, bool),
        "pair": np.ones(shape, bool),
    }
    return TruthTable(tuple("abcdef"[: shape[1]]), np.arange(shape[0]) / FPS, xyz, **(marks | flags))


def still(frames: int, *places: tuple[float, float, float]) -> np.ndarray:
    return np.tile(np.array(places, "f8"), (frames, 1, 1))


def only(scores: dict[str, TargetScore]) -> TargetScore:
    (one,) = scores.values()
    return one

"""Messages to try a stage with: empty, with a row of plausible numbers, with unknown numbers."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from followspot.columns import Column
from followspot.messages import Array, Message
from followspot.room import Room
from followspot.tracking import Frame

Content = Literal["empty", "plausible", "unknown"]
BLACK = np.zeros((48, 64, 3), np.uint8)
"""A dark picture of the tiny room's cameras."""
_BINS = 16


def sample(
    kind: type[Message], content: Content, room: Room, camera: str, pixels: Array, seed: int = 0
) -> Message:
    """A message of a type. pixels: (H, W, C) uint8, the picture, for messages that contain one or have its
    size.

    plausible: one row a column, numbers between 0 and 1, first target, first cameras;
    unknown: the same with NaN for every float.
    """
    if kind is Frame:
        return Frame(camera, pixels)
    scalars = {name: _scalar(name, of, room, camera, content) for name, of in kind.scalars}
    sizes = {
        "T": len(room.targets),
        "H": pixels.shape[0],
        "W": pixels.shape[1],
        "C": pixels.shape[2],
        "B": _BINS,
    }
    rng = np.random.default_rng(seed)
    rows = 0 if content == "empty" else 1
    columns = {}
    for column in kind.columns:
        shape = tuple(sizes.get(s, rows) if isinstance(s, str) else s for s in column.shape)
        columns[column.name] = _values(column, shape, content, rng)
    return kind(**scalars, **columns)


def _scalar(name: str, kind: Any, room: Room, camera: str, content: Content) -> Any:
    if kind is str:
        known = {"camera": camera, "sensor": next(iter(room.sensors), "")}
        return known.get(name, "")
    if kind == tuple[str, ...]:
        return tuple(room.cameras) if name == "cameras" else tuple(room.targets)
    if kind is float:
        return float("nan") if content == "unknown" else 1.0 / 30.0
    return kind()


def _values(column: Column, shape: tuple[int, ...], content: Content, rng: np.random.Generator) -> Array:
    """Values of a column of this shape."""
    dtype = column.dtype
    if dtype.kind == "f":
        if content == "unknown":
            return np.full(shape, np.nan, dtype)
        if len(shape) >= 2 and shape[-1] == shape[-2]:  # a covariance
            return np.broadcast_to(1e-4 * np.eye(shape[-1]), shape).astype(dtype)
        return rng.uniform(0.0, 1.0, shape).astype(dtype)
    if dtype.kind == "b":
        return np.ones(shape, dtype)
    if len(shape) > 1 and dtype.kind == "i":  # a pair of different things
        return np.broadcast_to(np.arange(shape[-1]), shape).astype(dtype)
    return np.ones(shape, dtype) if dtype.kind == "u" else np.zeros(shape, dtype)

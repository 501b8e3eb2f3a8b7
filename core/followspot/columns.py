"""The contract of one array field of a message: shape, dtype and unit, and how tables show it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

MAX_DIMENSIONS = 8
"""Largest number of dimensions of a column."""


class Column(NamedTuple):
    """The contract of one array field."""

    name: str
    shape: tuple[int | str, ...]
    dtype: np.dtype[Any]
    unit: str
    refers: str = ""
    """For indices, the list that they index: "targets", "states" or a field of the message; else ""."""
    names: tuple[str, ...] = ()
    """Names of its columns in a table; by default they follow from its own."""
    decimals: int | None = None
    """Digits after the point in a text file; None: as many as tell the number."""
    extra: bool = False
    """True if a text file leaves it out unless its columns are asked for by name."""


def check_column(owner: str, found: Column) -> None:
    """Raise TypeError if arrays of this column cannot be sent; owner: name of the message type."""
    name, shape, dtype, *_ = found
    if dtype.kind not in "biufc" or dtype.char in "gG":
        raise TypeError(f"{owner}.{name}: a column holds numbers or truth values, not dtype {dtype.str}")
    if found.refers and dtype.kind not in "iu":
        raise TypeError(f"{owner}.{name} holds indices, which are integers: give it a dtype such as i4")
    if len(shape) > MAX_DIMENSIONS:
        raise TypeError(f"{owner}.{name} has {len(shape)} dimensions, at most {MAX_DIMENSIONS}")
    if not all(isinstance(size, str) or (isinstance(size, int) and size >= 0) for size in shape):
        raise TypeError(f"{owner}.{name} has the shape {shape}: sizes are names, or whole numbers from 0")

"""Numbers of targets in a message with at most one row a target."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def target_numbers(target: Array, count: int) -> Array:
    """The numbers (M,) i4 of the targets that have a row, in this order.

    target: (M,) whole numbers; count: of targets of the room, 0 if it is not known. Raises ValueError if a
    number is that of no target, or there twice.
    """
    numbers = np.asarray(target, np.int32)
    if count and len({*numbers.tolist()} & {*range(count)}) < len(numbers):
        raise ValueError(
            f"positions of the targets {numbers.tolist()}: each of 0 to {count - 1}, as the room file "
            "lists them, may have one"
        )
    return numbers

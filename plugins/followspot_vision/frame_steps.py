"""Doubts about the numbers of frames that another program wrote."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

FEWEST = 10
"""Frames from which a step between all of them is no chance."""


def doubt_of_steps(numbers: Collection[int], fps: float) -> str:
    """Why the numbers of frames with rows look as if not every picture was searched; "" if they do not.

    A detector that looks at every fifth picture says nothing of the four between, but they count as pictures
    without people: tracks end there. fps: rate of the numbers.
    """
    steps = np.diff(sorted(numbers))
    step = int(np.gcd.reduce(steps)) if len(steps) else 1
    if len(numbers) < FEWEST or step < 2:
        return ""
    return (
        f"frames are numbered in steps of {step}, and those between count as empty: "
        f"number them 0, 1, 2, ... and say fps: {fps / step:g}"
    )


def doubt_of_gaps(numbers: Collection[int]) -> str:
    """Which files of pictures are missing between the first and the last; "" if none is."""
    if not numbers:
        return ""
    missing = max(numbers) - min(numbers) + 1 - len(numbers)
    if not missing:
        return ""
    first = next(number for number in range(min(numbers), max(numbers)) if number not in numbers)
    return f"{missing} pictures have no file, the first of them {first}, and count as empty"

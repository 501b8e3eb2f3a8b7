"""Recordings of boards that were exchanged: each shows the board through the lens of the other camera."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Free, adjust

BETTER = 0.85
"""Ratio of the errors with exchanged lenses and with the own ones below which lenses are exchanged; where
they are not, the errors grow, and lenses that are alike leave them as they are."""


def require_own_lenses(cameras: Sequence[Camera], points: Array, pixel: Array, residual: Array) -> None:
    """Raises FollowspotError if the camera that fits worst and another one fit with exchanged lenses.

    points: (N, 3) m; pixel: (N, C, 2) px; residual: (N, C) px. Cameras with lenses that are alike cannot be
    told apart.
    """
    error = float(np.nanmedian(residual))
    worst = int(np.nanargmax(np.nanmedian(residual, axis=0)))
    for pair in _candidates(cameras):
        if worst in pair:
            swapped = adjust(exchanged(cameras, pair), points, pixel, Free())
            if np.nanmedian(swapped.residual) < BETTER * error:
                raise exchange_error(cameras, pair)


def exchange_that_helps(
    cameras: Sequence[Camera], start: Callable[[Sequence[Camera]], object]
) -> FollowspotError | None:
    """The exchange with which cameras find their places that they do not find with their own lenses.

    start: places cameras, or raises FollowspotError.
    """
    for pair in _candidates(cameras):
        try:
            start(exchanged(cameras, pair))
        except FollowspotError:
            continue
        return exchange_error(cameras, pair)
    return None


def exchanged(cameras: Sequence[Camera], pair: tuple[int, int]) -> list[Camera]:
    """The cameras, two of them with the lens of the other."""
    a, b = pair
    found = list(cameras)
    for one, other in ((a, b), (b, a)):
        lens = cameras[other]
        found[one] = replace(cameras[one], matrix=lens.matrix, distortion=lens.distortion, model=lens.model)
    return found


def exchange_error(cameras: Sequence[Camera], pair: tuple[int, int]) -> FollowspotError:
    """The error for exchanged recordings, with its remedy."""
    one, other = (cameras[number].name for number in pair)
    return FollowspotError(
        f"the recordings of {one} and {other} are exchanged: each shows the board through the lens that the "
        "room gives to the other; exchange the recordings, or the lenses in the room file"
    )


def _candidates(cameras: Sequence[Camera]) -> Iterator[tuple[int, int]]:
    """Pairs with pictures of one size and different lenses."""
    for a, b in combinations(range(len(cameras)), 2):
        one, other = cameras[a], cameras[b]
        alike = np.array_equal(one.matrix, other.matrix) and np.array_equal(one.distortion, other.distortion)
        if one.size == other.size and not alike:
            yield a, b

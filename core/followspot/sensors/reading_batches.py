"""Batches of readings: how many readings of an inertial sensor make a message."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from followspot.frame_times import to_ns
from followspot.messages import Array
from followspot.stage_params import Field, StageParams


class BatchParams(StageParams):
    """Parameters of sources of `followspot.inertial.Inertial`. A message is complete by what comes first."""

    batch: int = Field(
        10,
        ge=1,
        le=10_000,
        unit="readings",
        description="largest number of readings in a message; larger messages cost less, but are later",
    )
    batch_time: float = Field(
        0.01,
        gt=0,
        le=10,
        unit="s",
        description="longest time between the first and the last reading of a message",
    )


def batches(time: Array, params: BatchParams) -> Iterator[slice]:
    """The rows of each message. time: (N,) rising, ns."""
    span, start = to_ns(params.batch_time), 0
    while start < len(time):
        within = int(np.searchsorted(time[start : start + params.batch], time[start] + span))
        yield slice(start, start + max(1, within))
        start += max(1, within)

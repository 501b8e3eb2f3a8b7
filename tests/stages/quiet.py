"""Stages for tests: they give little, or nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Field, Joined, Latest, Source, Stage, StageParams, at
from followspot.tracking import Blobs


def blobs(rows: int) -> Blobs:
    zeros = np.zeros(rows)
    return Blobs("cam0", np.zeros((rows, 2)), np.zeros((rows, 2)), zeros, zeros, np.zeros((rows, 1), bool))


class Emit(Stage):
    """Gives messages with so many rows."""

    class Params(StageParams):
        rows: int = Field(1, description="rows", unit="1")
        first: int = Field(0, description="number of the first message with rows", unit="1")

    def process(self) -> Source[Blobs]:
        for n in range(10):
            yield at(n + 1, blobs(self.params.rows if n >= self.params.first else 0))


class Pass(Stage):
    """Gives what it gets."""

    def process(self, blobs: Blobs) -> Blobs:
        return blobs


class Drop(Stage):
    """Gives messages without rows."""

    advice = "look elsewhere"

    def process(self, blobs: Blobs) -> Blobs:
        return blobs.where(slice(0))


class Broken(Stage):
    """Gives messages of the wrong shape, and the last one without rows."""

    def process(self, blobs: Blobs) -> Blobs:
        if blobs.header.time == 10:
            return blobs.where(slice(0))
        return replace(blobs, area=np.zeros(7))


class Never(Stage):
    """Gives no message."""

    def process(self, blobs: Blobs) -> Blobs | None:
        return None


class Both(Stage):
    """Needs two inputs."""

    def process(self, left: Blobs, right: Blobs, hint: Latest[Blobs] = None) -> Blobs:
        return right


class Merge(Stage):
    """Gives the first of what it gets."""

    def process(self, blobs: Joined[Blobs]) -> Blobs:
        return blobs[0]


class Save(Stage):
    """A sink."""

    def process(self, blobs: Blobs) -> None:
        return None


class Shifted(Stage):
    """Gives messages at times of its own."""

    def process(self) -> Source[Blobs]:
        for n in range(10):
            yield at(10**9 * (n + 1), blobs(1))

"""Recorded ground truth."""

from __future__ import annotations

import numpy as np

from followspot import Field, InputPath, Source, Stage, StageParams, at
from followspot.tracking import Truth
from followspot_accuracy import read_truth_csv


class TruthCsv(Stage):
    """Ground truth from a CSV file: time (s), object, x, y, z (m), hidden, trackable, pair (0, 1)."""

    class Params(StageParams):
        path: InputPath = Field(description="the CSV file; columns beyond these are ignored")

    params: Params

    def setup(self) -> None:
        """Read the file whole. Raises InputError with line numbers."""
        self.truth = read_truth_csv(self.params.path)

    def length(self) -> int:
        """Number of frames."""
        return len(self.truth.time)

    def process(self) -> Source[Truth]:
        """One message per time, with the objects that are present."""
        truth = self.truth
        there = np.asarray(np.isfinite(truth.xyz).all(axis=2))
        for f, time in enumerate(truth.time):
            rows = there[f]
            yield at(
                round(time * 1e9),
                Truth(
                    objects=tuple(name for name, row in zip(truth.objects, rows, strict=True) if row),
                    xyz=truth.xyz[f, rows],
                    hidden=truth.hidden[f, rows],
                    trackable=truth.trackable[f, rows],
                    pair=truth.pair[f, rows],
                ),
                seq=f,
            )

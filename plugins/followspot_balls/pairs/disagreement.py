"""Disagreement of cameras about tracked targets: a sign of a wrong calibration."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates

EACH = 8
"""One frame in so many is sampled."""
MOST = 256
"""Number of stored frames; the oldest are dropped."""
FEWEST = 200
"""Smallest number of pairs for a judgement."""
UNCOVERED = 0.8
"""Smallest area of both blobs of a pair that counts, over that of the whole ball: the centre of a blob is off
if the ball is hidden in part, however good the calibration is."""
LIMIT = 0.05
"""Median distance of a blob from the epipolar line of its partner, over the width of the blobs, beyond which
cameras disagree. A good calibration gives at most 0.03, with lamps anywhere on the balls."""


class Sample(NamedTuple):
    """N pairs of tracked targets in one frame."""

    epipolar: Array
    """(N,) px."""
    area: Array
    """(N, 2) px."""


class Disagreement:
    """Collects pairs of tracked targets and judges at the end.

    A blob that is merged with other light spoils some pairs, a camera that is off most of its pairs.
    """

    def __init__(self) -> None:
        self.samples: deque[Sample] = deque(maxlen=MOST)
        self.frames = 0

    def due(self) -> bool:
        """Count a frame; whether its candidates are to be added."""
        self.frames += 1
        return self.frames % EACH == 0

    def add(self, candidates: Candidates, shown: Array) -> None:
        """Sample a frame. shown: (N, T) bool, tracked targets that each candidate shows uncovered."""
        rows = (candidates.targets & shown).any(axis=1)
        self.samples.append(Sample(candidates.epipolar[rows], candidates.area[rows]))

    def warning(self) -> str:
        """The warning for the user; empty if the cameras agree."""
        if not self.samples:
            return ""
        epipolar, area = (np.concatenate(parts) for parts in zip(*self.samples, strict=True))
        if len(epipolar) < FEWEST:
            return ""
        share = float(np.median(epipolar / np.sqrt(4 / np.pi * area.mean(axis=1))))
        if share <= LIMIT:
            return ""
        return (
            f"cameras contradict each other about targets by {np.median(epipolar):.2f} px (median of their "
            f"epipolar distances, {100 * share:.0f} % of a target's width): their calibration is off, which "
            "`followspot calibrate refine --room ROOM.yaml --clips CLIPS` corrects, or they are not "
            "synchronised (`followspot calibrate clocks`)"
        )

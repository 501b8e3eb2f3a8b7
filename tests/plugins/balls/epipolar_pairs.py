"""Pairs of blobs with known distances from their epipolar lines."""

from __future__ import annotations

import numpy as np

from followspot.tracking import Candidates

WIDTH = 7.0
BALL = np.pi / 4 * WIDTH**2
YES, NO = np.array([True, False]), np.array([False, True])


def candidates(epipolar: list[float]) -> Candidates:
    """Pairs of the first of two targets with these epipolar distances, px; blobs are 7 px wide."""
    count = len(epipolar)
    return Candidates(
        cameras=("cam0", "cam1"),
        xyz=np.zeros((count, 3)),
        view=np.tile(np.array([0, 1], np.int32), (count, 1)),
        blob=np.zeros((count, 2), np.int32),
        xy=np.zeros((count, 2, 2)),
        area=np.full((count, 2), BALL),
        epipolar=np.array(epipolar),
        labelled=np.ones(count, bool),
        confirmed=np.ones(count, bool),
        evident=np.ones(count, bool),
        targets=np.tile(YES, (count, 1)),
        clutter=np.ones((count, 2)),
    )

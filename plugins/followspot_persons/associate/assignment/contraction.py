"""Clusters of detections over cameras: a partition, and therefore consistent round every cycle of cameras."""

from __future__ import annotations

import numpy as np

from followspot import Array


def clusters(ratio: Array) -> list[Array]:
    """Rows of each cluster of two or more detections, the most certain first.

    ratio: (N, N), symmetric: log-likelihood ratio of two detections being one body against two; -inf if they
    cannot be, as two of one camera. The two clusters with the largest sum of ratios are joined as long as it
    is above 0 (greedy additive edge contraction, Keuper et al. 2015). Since no cluster has two detections of
    a camera, whatever a detection is joined with over other cameras agrees.
    """
    left = np.array(ratio, float)
    np.fill_diagonal(left, -np.inf)
    members = [[row] for row in range(len(left))]
    gained = np.zeros(len(left))
    while left.size and left.max() > 0:
        a, b = divmod(int(left.argmax()), len(left))
        gained[a] += gained[b] + left[a, b]
        members[a] += members[b]
        members[b] = []
        left[a] += left[b]
        left[:, a] = left[a]
        left[b] = left[:, b] = left[a, a] = -np.inf
    found = [row for row in np.argsort(-gained, kind="stable") if len(members[row]) > 1]
    return [np.sort(members[row]) for row in found]

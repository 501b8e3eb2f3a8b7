"""Clusters of detections over cameras: a partition, and therefore consistent round every cycle of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array

LEAST_GAIN = 1.0
"""By how much a partition with more clusters must be worth more, nats."""
MOST_SOUGHT = 100
"""Number of other partitions that are sought in a set: 60 false boxes in each of four pictures have 66."""


class Partition(NamedTuple):
    """Clusters of detections. rows: of each cluster of two or more, the most certain first; total: what they
    are worth together; first: of each cluster the two detections that were joined first.

    A cluster of k detections is worth k - 1 times the mean ratio of its pairs, for so many are independent.
    """

    rows: Sequence[Array]
    total: float
    first: Sequence[tuple[int, int]]


def clusters(ratio: Array, least_gain: float = LEAST_GAIN) -> Sequence[Array]:
    """Rows of each cluster of two or more detections, the most certain first.

    ratio: (N, N), symmetric: log-likelihood ratio of two detections being one body against two; -inf if they
    cannot be, as two of one camera. Since no cluster has two detections of a camera, whatever a detection is
    joined with over other cameras agrees.

    Two detections of different people may fit better than those of each, and then take them from each other.
    So the partition is sought again without each pair that was joined first, and replaced by one with more
    clusters that is worth more. least_gain: by how much, nats: false detections, too, agree by chance.
    """
    ratio = np.array(ratio, float)
    best = contracted(ratio)
    left = list(best.first)
    for _ in range(MOST_SOUGHT):
        if not left:
            break
        a, b = left.pop(0)
        without = ratio.copy()
        without[a, b] = without[b, a] = -np.inf
        other = contracted(without)
        if len(other.rows) > len(best.rows) and other.total > best.total + least_gain:
            best, ratio, left = other, without, list(other.first)
    return best.rows


def contracted(ratio: Array) -> Partition:
    """The clusters of greedy additive edge contraction (Keuper et al. 2015): the two clusters with the
    largest sum of ratios are joined as long as it is above 0. ratio: (N, N) as for :func:`clusters`.
    """
    left = np.array(ratio, float)
    np.fill_diagonal(left, -np.inf)
    members = [[row] for row in range(len(left))]
    first: dict[int, tuple[int, int]] = {}
    gained = np.zeros(len(left))
    while left.size and left.max() > 0:
        a, b = divmod(int(left.argmax()), len(left))
        if a not in first:
            first[a] = first.pop(b, (a, b))
        gained[a] += gained[b] + left[a, b]
        members[a] += members[b]
        members[b] = []
        left[a] += left[b]
        left[:, a] = left[a]
        left[b] = left[:, b] = left[a, a] = -np.inf
    found = [row for row in np.argsort(-gained, kind="stable") if len(members[row]) > 1]
    worth = sum(2 * gained[row] / len(members[row]) for row in found)
    return Partition([np.sort(members[row]) for row in found], worth, [first[row] for row in found])

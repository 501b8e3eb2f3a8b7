"""One person for several finds of the same body, by object keypoint similarity (Lin et al. 2014, COCO)."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.panorama import short_way
from followspot_persons.pose_net.contract import People

SPREAD = 0.1
"""Deviation of a joint relative to the body's scale, about the mean of those of COCO."""


def distinct(people: People, minimum: float, most: float, turn: float) -> Array:
    """Rows of the people, the best first, without those that are as similar as `most` to a better one.

    minimum: certainty of joints that count; turn: columns of a full turn, px, 0 for none.
    """
    kept: list[int] = []
    for row in np.argsort(-people.score, kind="stable").tolist():
        if not (_similarity(people, row, kept, minimum, turn) > most).any():
            kept.append(row)
    return np.array(kept, int)


def _similarity(people: People, row: int, others: list[int], minimum: float, turn: float) -> Array:
    """Object keypoint similarity of a person with others, (K,), 0 to 1; 0 without a joint of both."""
    apart = people.pixel[others] - people.pixel[row]
    apart[..., 0] = short_way(apart[..., 0], turn)
    both = (people.certainty[others] >= minimum) & (people.certainty[row] >= minimum)
    area = np.ptp(people.pixel[row], axis=0).prod()
    close = np.exp(-np.square(apart).sum(axis=2) / (2 * max(float(area), 1.0) * (2 * SPREAD) ** 2))
    return np.asarray((close * both).sum(axis=1) / np.maximum(both.sum(axis=1), 1))

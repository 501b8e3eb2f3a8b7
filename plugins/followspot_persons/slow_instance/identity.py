"""Re-identification of persons by colours and height (sections 3.3 and 5)."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.color.difference import ColorRelations
from followspot_persons.color.hsi import plane
from followspot_persons.color.model import ColorModel

LIGHT_SIGMA = np.array([0.05, 0.05, 0.10])
"""Sigma of the change of a feature's mean colour with light and pose, in the plane of `hsi.plane`."""
STATURE_SIGMA = 0.04
"""One sigma of the difference between two measured heights of one person, m."""
POPULATION_SIGMA = 0.13
"""The same of two different people, m."""
INDEPENDENT_SHARE = 0.25
"""Share of the features that speak independently: neighbours wear the same."""
MISPLACED_SHARE = 0.1
"""Share of the features that show something else: an arm, a bag, the background."""


def same_person(
    a: ColorModel, b: ColorModel, statures: tuple[float, float], relations: ColorRelations
) -> float:
    """Log of how much likelier two models are of one person than of two.

    Each feature seen in both counts by its evidence, and may be misplaced; statures: m, of a and b.
    """
    weight = np.minimum(a.evidence, b.evidence)
    weight = INDEPENDENT_SHARE * weight / np.maximum(weight + 1.0, 1e-9)
    difference = plane(a.mean) - plane(b.mean)
    own = np.column_stack([np.diag(relations.chroma)] * 2 + [np.diag(relations.intensity)])
    ratio = _log_ratio(difference, LIGHT_SIGMA**2, LIGHT_SIGMA**2 + 2 * own).sum(axis=1)
    colors = (weight * np.logaddexp(np.log(1 - MISPLACED_SHARE) + ratio, np.log(MISPLACED_SHARE))).sum()
    height = _log_ratio(
        np.array(statures[0] - statures[1]), np.array(STATURE_SIGMA**2), np.array(POPULATION_SIGMA**2)
    )
    return float(colors + height)


def _log_ratio(difference: Array, same: Array, other: Array) -> Array:
    """Log-ratio of two Gaussians about 0 with these variances."""
    square = difference**2
    return np.asarray(0.5 * (square / other - square / same + np.log(other / same)))

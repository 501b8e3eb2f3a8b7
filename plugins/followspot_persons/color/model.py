"""The appearance of one person: colours of the surface features, learnt while visible (section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.color.hsi import from_plane, plane

FIRST_VARIANCE = np.array([0.04, 0.08, 0.12]) ** 2
"""Initial variance of a feature, in HSI."""
FIRST_EVIDENCE = 2.0
"""Weight of the initial variance, in observations."""


@dataclass(frozen=True, eq=False)
class ColorModel:
    """mean, variance: (F, 3) HSI; evidence: (F,) weight of the observations, 0 for a feature never seen."""

    mean: Array
    variance: Array
    evidence: Array

    @classmethod
    def unseen(cls, features: int) -> ColorModel:
        """A person without observations."""
        return cls(np.zeros((features, 3)), np.tile(FIRST_VARIANCE, (features, 1)), np.zeros(features))


def learnt(model: ColorModel, colors: Array, weight: Array, memory: float) -> ColorModel:
    """The model after one more observation: recursive maximum likelihood with limited memory.

    colors: (F, 3) HSI; weight: (F,), visibility, 0 for a feature that was not seen; memory: largest evidence,
    so that the newest observation keeps a share of 1 / memory. The mean is one of colours, not of hues.
    """
    evidence = np.minimum(model.evidence + weight, memory)
    share = np.divide(weight, evidence, out=np.zeros(len(weight)), where=evidence > 0)[:, None]
    old = plane(model.mean)
    mean = from_plane(old + share * (plane(colors) - old))
    difference = colors - mean
    difference[:, 0] -= np.rint(difference[:, 0])
    share = share * (evidence / (evidence + FIRST_EVIDENCE))[:, None]
    variance = model.variance + share * (difference**2 - model.variance)
    return ColorModel(mean, variance, evidence)

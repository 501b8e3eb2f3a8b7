"""Fitness of a pose from several cues: the Gamma operation of fuzzy logic (Weinrich et al. 2010, eq. 7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array


def gamma_operation(cues: Sequence[Array], shares: Sequence[float], gamma: float) -> Array:
    """Gamma (prod alpha F)^(1/|M|) + (1 - gamma) (sum alpha F) / |M|.

    A compromise between the product of independent observations and their mean: the cues are neither.
    cues: |M| arrays F (P,), 0 to 1; shares: their alpha; gamma: 0 to 1. Returns (P,).
    """
    weighted = np.stack([share * cue for cue, share in zip(cues, shares, strict=True)])
    product = np.prod(weighted, axis=0) ** (1 / len(weighted))
    return np.asarray(gamma * product + (1 - gamma) * weighted.mean(axis=0))

"""The identity as a dimension of the state (Weinrich et al. 2010, section 4): people may be where others are.

Each identity has its own set of particles, so that resampling cannot remove an identity. A change of identity
copies particles from one set to another, where the colours of the new person weigh them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array


def changed(people: Sequence[Array], share: float, rng: np.random.Generator) -> list[Array]:
    """Particles (N, 6) of each identity; a share of them is drawn anew from the particles of all others."""
    return [
        _drawn(own, [p for j, p in enumerate(people) if j != i], share, rng) for i, own in enumerate(people)
    ]


def _drawn(own: Array, others: Sequence[Array], share: float, rng: np.random.Generator) -> Array:
    """(N, 6); without others nothing changes."""
    count = int(share * len(own)) if others else 0
    if not count:
        return own
    pool = np.concatenate(others)
    return np.concatenate([own[: len(own) - count], pool[rng.integers(len(pool), size=count)]])

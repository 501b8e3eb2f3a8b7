"""A linear support vector machine by dual coordinate descent (Hsieh et al. 2008, algorithm 1)."""

from __future__ import annotations

import numpy as np

from followspot import Array

EPOCHS = 40
TOLERANCE = 1e-3
"""Largest projected gradient of an epoch at which the search stops."""


def fit(X: Array, sign: Array, cost: Array, rng: np.random.Generator) -> Array:
    """Weights w that minimise |w|^2 / 2 + sum of cost * max(0, 1 - sign * w x)^2.

    X: (N, D) f4, the last column 1 for the bias; sign: (N,) +1 or -1; cost: (N,). Returns (D,) f4.
    """
    alpha = np.zeros(len(X))
    w = np.zeros(X.shape[1], np.float32)
    ridge = 0.5 / cost
    curvature = np.einsum("ij,ij->i", X, X) + ridge
    for _ in range(EPOCHS):
        worst = 0.0
        for i in rng.permutation(len(X)).tolist():
            slope = sign[i] * float(X[i] @ w) - 1 + alpha[i] * ridge[i]
            if alpha[i] == 0 and slope >= 0:
                continue
            worst = max(worst, abs(slope))
            moved = max(alpha[i] - slope / curvature[i], 0.0)
            w += np.float32((moved - alpha[i]) * sign[i]) * X[i]
            alpha[i] = moved
        if worst < TOLERANCE:
            break
    return w

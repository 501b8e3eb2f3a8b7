"""Probabilistic data association: a measurement may be of something else than its target."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def association_probability(squared: Array, gate: float) -> Array:
    """The probability that unsure measurements are of their targets: (M,), 0.5 to 1.

    Clutter is assumed to have the same density everywhere, equal to that of the target at the gate. Beyond
    the gate it is equally likely that the target bounced and that the measurement is of something else.
    squared: (M,), n^T S^-1 n of the innovations n; gate: sigmas.
    """
    return np.asarray(1 / (1 + np.exp(np.minimum(squared - gate * gate, 0.0) / 2)))


def mixed(x: Array, P: Array, x_other: Array, P_other: Array, probability: Array) -> tuple[Array, Array]:
    """Mean and covariance, symmetric to the last bit, of mixtures of two Gaussians.

    See Bar-Shalom, Li & Kirubarajan 2001, section 1.4.16.

    x, x_other: (M, D); P, P_other: (M, D, D); probability: (M,), of the first.
    """
    share = probability[:, None]
    apart = x - x_other
    spread = np.sqrt(share * (1 - share)) * apart
    covariance = share[..., None] * P + (1 - share)[..., None] * P_other
    covariance += spread[:, :, None] * spread[:, None]
    return x_other + share * apart, (covariance + covariance.swapaxes(1, 2)) / 2

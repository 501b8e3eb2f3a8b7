"""Measurements that may be of something else than their target: probabilistic data association."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def association_probability(squared: Array, gate: float) -> Array:
    """The probability that unsure measurements are of their targets: (M,), 0.5 to 1.

    What else there is has the same density everywhere: that which the target has at the gate. Beyond it the
    target bounced, or the measurement is of something else, which are equally likely.
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

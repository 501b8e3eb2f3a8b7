"""How well colours of a picture agree with what a person looks like (Weinrich et al. 2010, section 3.3)."""

from __future__ import annotations

import numpy as np

from followspot import Array

DARK, BRIGHT = 0.12, 0.88
"""Intensities beyond which the hue is noise."""
RAMP = 0.12
"""Width of the transition, in intensity."""
NARROWEST = np.array([0.03, 0.06, 0.10], np.float32)
"""Smallest sigmas of hue, saturation and intensity, at which a Gaussian's peak counts as 1."""
FLOOR = np.float32(0.03)
"""Response of a feature that shows another colour altogether, an arm, a bag; not 0, for eq. 6 multiplies."""


def intensity_share(intensity: Array) -> Array:
    """lambda: 1 for dark and bright pixels, whose hue is noise, 0 for medium ones. Any shape, 0 to 1."""
    return np.asarray(np.clip(np.maximum(DARK - intensity, intensity - BRIGHT) / RAMP + 1, 0, 1))


def channel_responses(colors: Array, mean: Array, variance: Array) -> Array:
    """w_H, w_S, w_I: Gaussians of the colours, relative to the peak of the narrowest one.

    A wide Gaussian has a low peak, as a density has: what is not known does not fit well.
    colors: (P, F, 3); mean, variance: (F, 3). Returns (P, F, 3).
    """
    difference = colors - mean
    difference[..., 0] -= np.rint(difference[..., 0])
    peak = NARROWEST / np.sqrt(np.maximum(variance, NARROWEST**2))
    scale = -0.5 / np.maximum(variance, NARROWEST**2)
    return np.asarray(peak * np.exp(difference * difference * scale))


def feature_responses(colors: Array, mean: Array, variance: Array) -> Array:
    """w: channels mixed by intensity (eq. 5), (P, F); the arguments of :func:`channel_responses`."""
    w = channel_responses(colors, mean, variance)
    share = intensity_share(colors[..., 2])
    return np.asarray(share * w[..., 2] + (1 - share) * w.mean(axis=-1))


def color_likelihood(responses: Array, visibility: Array) -> Array:
    """F^C: geometric mean of the responses, weighted by visibility (eq. 6). (P, F) each. Returns (P,)."""
    logs = np.log(np.maximum(responses, FLOOR))
    total = visibility.sum(axis=1)
    return np.asarray(np.exp((visibility * logs).sum(axis=1) / np.maximum(total, 1e-6)))

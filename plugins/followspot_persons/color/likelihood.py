"""The likelihood of a picture's colours given a person's colours (Weinrich et al. 2010, section 3.3)."""

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
"""Smallest response of a feature, as of an arm or a bag; not 0, because eq. 6 multiplies."""


def intensity_share(intensity: Array) -> Array:
    """lambda: 1 for dark and bright pixels, whose hue is noise, 0 for medium ones. Any shape, 0 to 1."""
    beyond = np.maximum(DARK - intensity, intensity - BRIGHT)
    return np.asarray(np.minimum(np.maximum(beyond / RAMP + 1, 0), 1))


def channel_responses(colors: Array, mean: Array, variance: Array) -> Array:
    """w_H, w_S, w_I: Gaussians of the colours, relative to the peak of the narrowest one.

    A wide Gaussian has a low peak, as a density: an uncertain colour does not fit well.
    colors: (P, F, 3); mean, variance: (F, 3). Returns (P, F, 3).
    """
    wide = np.maximum(variance, NARROWEST**2)
    peak, scale = NARROWEST / np.sqrt(wide), -0.5 / wide
    out = np.empty((3, *colors.shape[:-1]), np.result_type(colors, mean))
    for channel, response in enumerate(out):
        np.subtract(colors[..., channel], mean[:, channel], out=response)
        if channel == 0:
            response -= np.rint(response)
        np.square(response, out=response)
        response *= scale[:, channel]
        np.exp(response, out=response)
        response *= peak[:, channel]
    return np.moveaxis(out, 0, -1)


def feature_responses(colors: Array, mean: Array, variance: Array) -> Array:
    """w: channels mixed by intensity (eq. 5), (P, F); the arguments of :func:`channel_responses`."""
    hue, saturation, intensity = np.moveaxis(channel_responses(colors, mean, variance), -1, 0)
    share = intensity_share(colors[..., 2])
    return np.asarray(share * intensity + (1 - share) * (hue + saturation + intensity) * np.float32(1 / 3))


def color_likelihood(responses: Array, visibility: Array) -> Array:
    """F^C: geometric mean of the responses, weighted by visibility (eq. 6). (P, F) each. Returns (P,)."""
    logs = np.log(np.maximum(responses, FLOOR))
    total = visibility.sum(axis=1)
    return np.asarray(np.exp((visibility * logs).sum(axis=1) / np.maximum(total, 1e-6)))

"""Other tones of hair and skin, for the few people of a data set have few."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.cells import colours
from followspot_persons.hog.window import BODY, HEIGHT, TALL, WIDTH

RECOLOURED = 0.85
"""Share of the windows that get other tones."""
HEAD_TALL = 0.42
"""Height of the region of the head, hair included, over that of the upper body."""
HAIR = (25.0, 230.0)
"""Range of the mean grey level of hair."""
TINT = 0.08
"""Standard deviation of the logarithm of each channel of hair, about grey."""
SKIN_MEAN, SKIN_SIGMA = -0.3, 0.5
"""Of the logarithm of the factor of skin's brightness: darker skins are rarer in the pictures."""


def recoloured(window: Array, rng: np.random.Generator) -> Array:
    """A window, (HEIGHT, WIDTH, 3) u8, in most cases with hair and skin of another tone.

    Hair is taken to be what is not like skin in the region of the head, so that some background near the
    head changes as well.
    """
    if rng.random() >= RECOLOURED:
        return window
    likeness = colours(window)[3]
    skin = cv2.GaussianBlur(np.clip(2 * likeness, 0, 1), (0, 0), 1.0)[..., None]
    hair = HEAD * (1 - skin)
    pixels = window.astype(np.float32)
    pixels += hair * (_hair(pixels, hair, rng) - pixels)
    pixels += skin * pixels * np.expm1(rng.normal(SKIN_MEAN, SKIN_SIGMA))
    return np.asarray(np.clip(pixels, 0, 255), np.uint8)


def _hair(pixels: Array, hair: Array, rng: np.random.Generator) -> Array:
    """The pixels in a new tone of nearly grey, with their differences of brightness."""
    grey = pixels.mean(axis=2, keepdims=True)
    usual = max(20.0, float((grey * hair).sum() / max(float(hair.sum()), 1.0)))
    tone = rng.uniform(*HAIR) * np.exp(rng.normal(0, TINT, 3))
    return np.asarray(np.minimum(grey / usual * tone, 255))


def _head() -> Array:
    """(HEIGHT, WIDTH, 1), 1 within the head and hair, falling to 0 around."""
    tall = HEAD_TALL * TALL
    row, column = np.mgrid[:HEIGHT, :WIDTH]
    down = (row - (BODY[1] + 0.36 * tall)) / (0.5 * tall)
    aside = (column - WIDTH / 2) / (0.4 * tall)
    return np.asarray(np.clip(1.5 - down**2 - aside**2, 0, 1)[..., None], np.float32)


HEAD = _head()

"""Particles at one pose, the eye that sees them, and the random numbers of a test."""

from __future__ import annotations

import numpy as np

EYE = np.array([0, 0, 1.2])


def crowd(pose, count):
    return np.tile(pose, (count, 1))


def rng():
    return np.random.default_rng(8)

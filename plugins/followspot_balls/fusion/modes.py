"""Mean shift: modes of weighted candidates, for all targets at once (Jin & Qian 2008, section 3.6, eq. 4)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.fusion.kernels import kernel, scales, squared_distances

TINY = np.finfo(float).tiny


class Sample(NamedTuple):
    """N candidates with weights for M targets."""

    xyz: Array
    """(N, 3) m."""
    labelled: Array
    """(N,) bool."""
    weights: Array
    """(M, N); 0 if a candidate is not the target's. Each row has one above 0."""
    bandwidth: Array
    """(M, 3) m."""

    def rows(self, chosen: Array) -> Sample:
        """The sample of some of the targets."""
        return self._replace(weights=self.weights[chosen], bandwidth=self.bandwidth[chosen])


class Modes(NamedTuple):
    """The converged centres."""

    center: Array
    """(M, 3) m."""
    held: Array
    """(M, N) weight of each candidate inside the kernel, 0 outside."""
    total: Array
    """(M,) their sum."""
    steps: Array
    """(M,) steps until convergence."""


def seek_modes(start: Array, sample: Sample, tolerance: float, steps: int) -> Modes:
    """Move each centre to the weighted mean of the candidates in its kernel (eq. 4) until it converges.

    A centre with an empty kernel does not move.
    start: (M, 3) m; tolerance: length of the last step, m; steps: at most.
    """
    center, taken = start, np.zeros(len(start), int)
    moving = np.ones(len(start), bool)
    scale, unlabelled = scales(sample.bandwidth), 1.0 - sample.labelled
    across = np.ascontiguousarray(sample.xyz.T)  # long rows are computed faster
    for step in range(1, steps + 1):
        held = kernel(across - center[..., None], scale, unlabelled)
        held *= sample.weights
        total = held.sum(axis=1)
        free = moving & (total > 0)
        mean = (held @ sample.xyz) / np.maximum(total, TINY)[:, None]
        mean = np.where(free[:, None], mean, center)
        taken[moving] = step
        travel = mean - center
        moving = np.vecdot(travel, travel) >= tolerance * tolerance
        center = mean
        if not np.count_nonzero(moving):
            break
    return Modes(center, held, total, taken)


def weighted_mean(xyz: Array, weights: Array) -> Array:
    """Sum w x / sum w: (N, 3) m and (M, N) -> (M, 3) m; zero if all weights are."""
    total = weights.sum(axis=1, keepdims=True)
    return np.asarray(weights @ xyz / np.maximum(total, TINY))


def densest(sample: Sample, credit: Array) -> Array:
    """The densest candidate of each target.

    credit: (M, N) factor of each candidate's density, 0 if it must not be chosen. Returns (M, 3) m.
    """
    eligible = credit * sample.weights > 0
    chosen, left = np.empty(len(credit), int), np.ones(len(credit), bool)
    while left.any():  # lost targets have one bandwidth
        same = left & (sample.bandwidth == sample.bandwidth[left.argmax()]).all(axis=1)
        seeds = eligible[same].any(axis=0).nonzero()[0]
        density = sample.weights[same] @ kernel_matrix(sample, sample.bandwidth[same][:1], seeds)
        density *= np.where(eligible[same], credit[same], -1.0).take(seeds, axis=1)
        chosen[same] = seeds.take(density.argmax(axis=1))
        left &= ~same
    return sample.xyz.take(chosen, axis=0)


def kernel_matrix(sample: Sample, bandwidth: Array, seeds: Array) -> Array:
    """Weights of N candidates by their distances from some of them: (N, S). bandwidth: (1, 3) m."""
    xyz, (scale,) = sample.xyz, scales(bandwidth)
    inside = squared_distances(xyz, xyz.take(seeds, axis=0), scale[0]) < 1.0
    weight = inside.T.astype(float)
    seed, candidate = (inside & ~sample.labelled).nonzero()
    offset = xyz.take(candidate, axis=0) - xyz.take(seeds.take(seed), axis=0)
    weight[candidate, seed] = np.exp(-((offset * offset) @ scale[1]))
    return weight

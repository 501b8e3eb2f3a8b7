"""The condensation of one person's pose: predict, climb, weigh, estimate, resample (algorithm 1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.geometry import wrap
from followspot_persons.body.view import HEADING, PAN, TILT
from followspot_persons.particles.ascent import ascend
from followspot_persons.particles.motion import limited, predicted
from followspot_persons.particles.swarm import swarmed

MODE = np.radians(60)
"""Largest angle from the best heading of the particles in the estimate."""
BINS = 24
"""Bins of the histogram of headings."""


@dataclass(frozen=True)
class Search:
    """Parameters of the particle search."""

    particles: int = 300
    random: float = 0.15
    """Share of random particles."""
    climbing: float = 0.2
    """Share of the best particles with a local search."""
    rounds: int = 1
    """Rounds of the local search at most."""
    swarm: bool = False
    """Whether particles that search locally are a swarm; otherwise they climb by gradient ascent."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Pose (6,) and its sigma (6,): m and rad."""

    pose: Array
    sigma: Array


def condense(
    particles: Array,
    velocity: Array,
    seconds: float,
    fitness: Callable[[Array], Array],
    eye: Array,
    search: Search,
    rng: np.random.Generator,
) -> tuple[Array, Estimate]:
    """Particles after a picture, and their estimate. particles: (N, 6); eye: (3,) m, the camera's centre."""
    cloud = predicted(particles, velocity, seconds, eye, rng)
    random = int(search.random * len(cloud))
    if random:
        cloud[:random] = scattered(cloud[:random], rng)
    value = fitness(cloud)
    climbers = int(search.climbing * len(cloud))
    if climbers and search.rounds:
        best = np.argpartition(value, -climbers)[-climbers:]
        if search.swarm:
            cloud[best], value[best] = swarmed(cloud[best], value[best], fitness, search.rounds, rng)
        else:
            cloud[best], value[best] = ascend(cloud[best], value[best], fitness, eye, search.rounds)
    weight = np.exp(value - value.max())
    weight /= weight.sum()
    estimate = estimated(cloud, weight)
    return cloud[systematic(weight, search.particles, rng)], estimate


def scattered(pose: Array, rng: np.random.Generator) -> Array:
    """Particles scattered about a person: a third turned by half a turn, the others at random."""
    out = pose.copy()
    third = len(out) // 3
    out[:third, HEADING] += np.pi
    out[third:, HEADING] = rng.uniform(-np.pi, np.pi, len(out) - third)
    out[:, PAN] = rng.normal(0, 0.5, len(out))
    out[:, TILT] = rng.normal(0, 0.15, len(out))
    out[2 * third :, :2] += rng.normal(0, 0.15, (len(out) - 2 * third, 2))
    return limited(out)


def systematic(weight: Array, count: int, rng: np.random.Generator) -> Array:
    """Rows drawn with these probabilities, by one random number. weight: (N,), sum 1. Returns (count,)."""
    places = (np.arange(count) + rng.random()) / count
    return np.minimum(np.searchsorted(np.cumsum(weight), places), len(weight) - 1)


def estimated(cloud: Array, weight: Array) -> Estimate:
    """Mean and sigma of the particles about the heading that most of the weight supports."""
    near = np.cos(cloud[:, HEADING] - best_heading(cloud[:, HEADING], weight)) > np.cos(MODE)
    share = np.where(near, weight, 0.0)
    share /= share.sum()
    reference = cloud[share.argmax()]
    difference = cloud - reference
    difference[:, HEADING] = wrap(difference[:, HEADING])
    mean = share @ difference
    sigma = np.sqrt(share @ (difference - mean) ** 2)
    pose = reference + mean
    pose[HEADING] = wrap(pose[HEADING])
    return Estimate(pose, sigma)


def best_heading(heading: Array, weight: Array) -> float:
    """The heading about which most weight lies, within two bins of the histogram on either side."""
    place = (heading * (BINS / (2 * np.pi))) % BINS
    bins = np.bincount(place.astype(np.intp) % BINS, weight, BINS)
    smooth = sum(np.roll(bins, k) * (3 - abs(k)) for k in range(-2, 3))
    return float((np.argmax(smooth) + 0.5) * 2 * np.pi / BINS)

"""Particle swarm optimisation, the paper's other local search (Weinrich et al. 2010, section 4).

Each pose flies towards the best place that it has been to and the best of the whole swarm (Kennedy &
Eberhart 1995, with the constriction of Clerc & Kennedy 2002).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot import Array
from followspot.geometry import wrap
from followspot_persons.body.view import HEADING
from followspot_persons.particles.motion import limited

INERTIA, PULL = 0.7298, 1.4962
"""Share of the velocity that stays, and the largest pull of each of the two best places."""
FIRST = np.array([0.05, 0.05, 0.02, 0.25, 0.25, 0.1])
"""One sigma of the first velocities: m, m, m, rad, rad, rad."""


def swarmed(
    pose: Array,
    value: Array,
    fitness: Callable[[Array], Array],
    rounds: int,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """The best place of each pose after some rounds, and its fitness. pose: (P, 6); value: (P,), theirs."""
    place, best, best_value = pose.copy(), pose.copy(), value.copy()
    velocity = FIRST * rng.standard_normal(pose.shape)
    for _ in range(rounds):
        own, common = rng.random((2, *pose.shape))
        velocity = INERTIA * velocity + PULL * own * _towards(place, best)
        velocity += PULL * common * _towards(place, best[best_value.argmax()])
        place = limited(place + velocity)
        reached = fitness(place)
        better = reached > best_value
        best = np.where(better[:, None], place, best)
        best_value = np.where(better, reached, best_value)
    return best, best_value


def _towards(place: Array, goal: Array) -> Array:
    """Differences to a goal, headings the short way round."""
    out = goal - place
    out[:, HEADING] = wrap(out[:, HEADING])
    return np.asarray(out)

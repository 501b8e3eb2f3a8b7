"""Places of the balls on a fine grid of times, computed once for all sensors of a process."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from followspot import Array
from followspot_sim.recent import Recent
from followspot_sim.world import Setting, world_of

BLOCK = 256


class Path:
    """The centres of all balls at (i - 1/2) / rate for whole i; before time 0 as at time 0."""

    def __init__(self, choice: Setting, rate: float) -> None:
        self._world, self._rate, self._offset = world_of(choice), rate, choice.clock_offset
        self._block = Recent(self._computed, size=8)

    def centres(self, first: int, count: int) -> Array:
        """At `count` times from number `first` on, (count, T, 3) m."""
        low, high = first // BLOCK, (first + count - 1) // BLOCK
        found = np.concatenate([self._block(block) for block in range(low, high + 1)])
        return np.asarray(found[first - low * BLOCK :][:count])

    def _computed(self, block: int) -> Array:
        times = (np.arange(block * BLOCK, (block + 1) * BLOCK) - 0.5) / self._rate + self._offset
        return np.array([self._world.balls(time) for time in times.tolist()])


@lru_cache(maxsize=4)
def path_of(choice: Setting, rate: float) -> Path:
    """The path of a setting, shared by the sensors of one process."""
    return Path(choice, rate)

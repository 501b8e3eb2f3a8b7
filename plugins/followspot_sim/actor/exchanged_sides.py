"""Mistakes of a network about left and right: for some time it names the limbs of one side by the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.actor.landmarks import NAMES

ASIDE = 0.9
"""How much likelier than from the side an exchange is from behind, and unlikelier from the front."""
_LIMBS = (
    ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle"),
    ("shoulder", "elbow", "wrist"),
)
_KINDS = (*_LIMBS, ("elbow", "wrist"), ("hip", "knee", "ankle"), ("knee", "ankle"))
"""Joints that are exchanged together; one kind in each period: the whole body, or its arms or legs."""
_WHOLE = 0.5
"""Share of the exchanges that are of the whole body."""
_SHARES = np.array([_WHOLE, *((1 - _WHOLE) / (len(_KINDS) - 1),) * (len(_KINDS) - 1)])
_OTHER = {"left": "right", "right": "left"}


def _mirror(words: tuple[str, ...]) -> list[int]:
    """For each landmark the one by whose name it goes if these joints are exchanged."""
    found = []
    for row, name in enumerate(NAMES):
        side, _, joint = name.partition("_")
        found.append(NAMES.index(f"{_OTHER[side]}_{joint}") if joint in words else row)
    return found


_MIRRORS = np.array([_mirror(kind) for kind in _KINDS])


@dataclass(frozen=True)
class Exchanges:
    """share: of the time, at the mean over the sides that people show; duration: of one exchange, s; seed:
    (S,) integers of the performance and the camera.
    """

    share: float
    duration: float
    seed: tuple[int, ...]

    def names(self, time: float, facing: Array) -> Array:
        """For each landmark of P people the one by whose name it goes, (P, 17). facing: (P,) cosine between
        where each chest points and where the camera is.
        """
        found = np.tile(np.arange(len(NAMES)), (len(facing), 1))
        if not self.share:
            return found
        for person, cosine in enumerate(facing):
            phase = np.random.default_rng([*self.seed, person]).random()
            period = int(time / self.duration + phase)
            rng = np.random.default_rng([*self.seed, person, period])
            if rng.random() < self.share * (1 - ASIDE * cosine):
                found[person] = _MIRRORS[rng.choice(len(_KINDS), p=_SHARES)]
        return found

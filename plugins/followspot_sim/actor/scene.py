"""The performance of actors: the surfaces of all of them at each frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from followspot import Array
from followspot_sim.actor.cast import cast_of
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.pose import Stance, posed
from followspot_sim.actor.way import Ways
from followspot_sim.recent import Recent


@dataclass(frozen=True, eq=False)
class Play:
    """One time: the poses, surfaces (V, 3) m each, heights (P,) m of the tops of the heads."""

    stances: list[Stance]
    surfaces: list[Array]
    heights: Array


@lru_cache(maxsize=4)
def stage_of(params: ActorParams) -> ActorStage:
    """The performance of some parameters, shared by the cameras of one process."""
    return ActorStage(params)


class ActorStage:
    """Any frame may be asked for at any time."""

    def __init__(self, params: ActorParams) -> None:
        self.cast = cast_of(params.seed, params.people)
        self._ways = Ways(params)
        self._fps = params.fps
        self.play = Recent(self._play)

    def _play(self, frame: int) -> Play:
        return self.at(frame / self._fps)

    def at(self, time: float) -> Play:
        """The performance at a time, s, between frames, too."""
        stances = self._ways.stances(time)
        surfaces = [posed(actor.body, stance) for actor, stance in zip(self.cast, stances, strict=True)]
        heights = [float(v[a.body.top, 2].max()) for a, v in zip(self.cast, surfaces, strict=True)]
        return Play(stances, surfaces, np.array(heights))

"""Base of the sources of simulated balls: the targets that their parameters name."""

from __future__ import annotations

from collections.abc import Iterable

from followspot import Room
from followspot.errors import Mistake
from followspot.room import Member
from followspot_sim.parameters import SimParams
from followspot_sim.performance import Performance
from followspot_sim.world import check_targets


class BallPerformance(Performance):
    """Base of sources with the parameters of `SimParams`."""

    @classmethod
    def check_files(cls, params: SimParams, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Raises InputError if a parameter names a target that the room has not."""
        check_targets(params, room)
        return ()

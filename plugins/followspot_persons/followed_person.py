"""What the fast instance knows of one person."""

from __future__ import annotations

from dataclasses import dataclass

from followspot.tracking import TRACKED
from followspot_persons.track import Track
from followspot_persons.trail import Trail


@dataclass(frozen=True, eq=False)
class Followed:
    """A tracked person.

    good, boxed: ns, times of the last picture that agreed, and of the last box of the detector; state: as in
    `Poses`.
    """

    number: int
    track: Track
    good: int
    boxed: int
    state: int = TRACKED
    trail: Trail = Trail()

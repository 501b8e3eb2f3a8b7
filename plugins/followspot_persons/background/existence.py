"""What the background says about the existence of a person: furniture never differs from it."""

from __future__ import annotations

from dataclasses import dataclass

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_persons.background.floor_contact import Presence, presence
from followspot_persons.background.scene import Scene

STILL, THERE = 0.2, 0.5
"""Shares of foreground on the upper body up to which no person is there, and from which a person is."""
EVIDENCE = 1.5
"""Log-likelihood ratio of one picture. Of all boxes in the development rooms the background tells those of
furniture more surely, but pictures in a row are hardly independent.
"""
RECENT = 0.3
"""Weight of the newest picture in a person's share of foreground."""

RIGID, RIGID_TIME = 0.005, 1.0
"""Share of foreground about a person that furniture does not exceed, and for how long it must not, s: a
person who stands still sways by some millimetres and breathes, which changes the outline.
"""


@dataclass(frozen=True)
class Stirring:
    """How much a person has stirred: since: ns, of the first comparison with the background, 0 for none;
    most: largest share of foreground about the person.
    """

    since: int = 0
    most: float = 0.0

    def after(self, shown: Presence | None, now: int) -> Stirring:
        """After one more picture of a time, ns."""
        if shown is None:
            return self
        return Stirring(self.since or now, max(self.most, shown.about))

    def furniture(self, now: int) -> bool:
        """Whether nothing has stirred for so long that it is no person."""
        return self.since > 0 and (now - self.since) * NANOSECOND >= RIGID_TIME and self.most < RIGID


def stirred(scene: Scene, pose: Array, others: Array) -> bool:
    """Whether anything about a person in a pose (6,) differs between two pictures; others: of `presence`."""
    shown = presence(scene, pose, others)
    return shown is None or shown.about >= RIGID


def evidence_of(foreground: float | None, *, comparable: bool) -> float:
    """Log-odds that a share of foreground adds to the score of a box; 0 if it is not known.

    comparable: whether the person cannot be a part of the background; otherwise a lack of foreground says
    nothing.
    """
    if foreground is None:
        return 0.0
    odds = EVIDENCE * min(1.0, max(-1.0, 2 * (foreground - STILL) / (THERE - STILL) - 1))
    return odds if comparable else max(0.0, odds)


def averaged(before: float | None, shown: Presence | None) -> float | None:
    """The mean share of foreground after one more picture, with a memory of some pictures."""
    if shown is None:
        return before
    return shown.foreground if before is None else before + RECENT * (shown.foreground - before)

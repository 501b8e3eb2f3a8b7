"""What the slow instance knows of one person."""

from __future__ import annotations

from dataclasses import dataclass, field

from followspot_persons.color.model import ColorModel
from followspot_persons.stature import Stature
from followspot_persons.track import Track


@dataclass(frozen=True, eq=False)
class Acquaintance:
    """A person of the slow instance: tentative, with number 0, until enough boxes confirm it.

    initiated, seen: ns, times of the first and of the last box; hits: number of boxes; trust: sum of their
    scores minus the cost of missing boxes; absent: whether the person has left; boxed: ns, of the
    detector's last box, while the foreground may prolong `seen`; foreground: mean share of the
    upper body that differs from the background, None while there is no background; comparable: whether the
    person came after the background, or once differed from it, and so is no part of it.
    """

    number: int
    track: Track
    colors: ColorModel
    initiated: int
    seen: int
    hits: int
    trust: float
    absent: bool = False
    boxed: int = 0
    foreground: float | None = None
    comparable: bool = False
    stature: Stature = field(default_factory=Stature)

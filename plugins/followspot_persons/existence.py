"""What the background says about the existence of a person: furniture never differs from it."""

from __future__ import annotations

from followspot_persons.floor_contact import Presence

STILL, THERE = 0.2, 0.5
"""Shares of foreground on the upper body at which nothing is there, and at which somebody is."""
EVIDENCE = 1.5
"""Log-likelihood ratio of one picture. Of all boxes in the development rooms the background tells those of
furniture more surely, but pictures in a row are hardly independent.
"""
RECENT = 0.3
"""Weight of the newest picture in a person's share of foreground."""


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

"""Existence of targets as log-odds that evidence moves, and rival places of targets that are sought.

The odds of a place multiply by the likelihood ratio of each frame (a sequential probability ratio test) and
are forgotten at a constant rate, because people cover and carry what made them. They are bounded, so that a
long-standing target can still be given up within a few frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from followspot.messages import Array

MOST = 4
"""Rival places of a target."""
BIRTHS = 3
"""New places in a frame."""


class Rules(NamedTuple):
    """How evidence moves log-odds, natural logarithms."""

    memory: float
    """Share of the log-odds that a frame keeps."""
    drift: float
    """What a frame takes from them, so that evidence of nothing ends a target."""
    bound: float
    """Largest log-odds."""
    silent: float
    """Log-odds below which a tracked target is given up."""


class Confirmation(NamedTuple):
    """When a place of a sought target is certain."""

    absent: float
    """What a frame without candidates there takes from its log-odds besides."""
    confirmed: float
    """Log-odds from which a place may be the target's."""
    margin: float
    """Smallest lead over a rival place."""
    reach: float
    """m, largest step of a target from frame to frame, and least distance of rival places."""


class Places(NamedTuple):
    """Rival places of one target, the likeliest first."""

    xyz: Array
    """(H, 3) m."""
    odds: Array
    """(H,) log-odds."""


NOWHERE = Places(np.zeros((0, 3)), np.zeros(0))
"""No place."""


class Seen(NamedTuple):
    """N candidates of one target."""

    xyz: Array
    """(N, 3) m."""
    gain: Array
    """(N,) log-likelihood ratio of a ball there."""
    complete: Array
    """(N,) bool, whether three views that all make pairs with each other show it."""


class Existence(NamedTuple):
    """What is known of one target's existence."""

    odds: float
    """Log-odds that the target is where it is tracked."""
    found: bool
    """Whether a sought target's place is certain."""
    places: Places
    """Rival places of a sought target."""

    @classmethod
    def unknown(cls) -> Existence:
        """Nothing is known."""
        return cls(0.0, False, NOWHERE)


def restored(state: Mapping[str, Any]) -> Existence:
    """The existence from its fields as plain values."""
    places = state["places"]
    rivals = Places(np.array(places["xyz"], float).reshape(-1, 3), np.array(places["odds"], float))
    return Existence(float(state["odds"]), bool(state["found"]), rivals)


def followed(before: Existence, gain: float, place: Array, rules: Rules, steps: float = 1.0) -> Existence:
    """A tracked target one frame later. A place that is given up stays a rival, with its odds.

    Frames that follow each other faster say less that is new, so a frame counts as a part of a step.
    gain: log-likelihood ratio of the frame; place: (3,) m; steps: that the frame counts as.
    """
    odds = rules.memory**steps * before.odds + steps * (gain - rules.drift)
    odds = float(max(-rules.bound, min(odds, rules.bound)))
    given_up = Places(place[None].copy(), np.array([odds])) if odds < rules.silent else NOWHERE
    return Existence(odds, False, given_up)


def sought(
    before: Existence, seen: Seen, around: Array | None, alike: int, rules: Rules, confirmation: Confirmation
) -> tuple[Existence, int]:
    """A sought target one frame later, and the candidate at its place, -1 unless that is certain.

    around: (3,) m, the place near which it was searched, None for everywhere; alike: see :func:`certain`.
    """
    searched = np.ones(len(before.places.odds), bool)
    if around is not None:
        searched = near(before.places.xyz, around, confirmation.reach)
    places, candidate = weighed(before.places, seen.xyz, seen.gain, searched, rules, confirmation)
    if not len(candidate) or candidate[0] < 0:
        return Existence(before.odds, False, places), -1
    first = int(candidate[0])
    already = before.found and bool(near(places.xyz[:1], before.places.xyz[0], confirmation.reach)[0])
    found = certain(places, confirmation, alike, already, bool(seen.complete[first]))
    odds = min(float(places.odds[0]), rules.bound) if found else before.odds
    return Existence(odds, found, places), first if found else -1


def weighed(
    places: Places, xyz: Array, gain: Array, searched: Array, rules: Rules, confirmation: Confirmation
) -> tuple[Places, Array]:
    """The rival places one frame later, and the candidate that each continues with: (H,), -1 for none.

    xyz: (N, 3) m, candidates; gain: (N,), their log-likelihood ratios; searched: (H,) bool, places where
    candidates could have been found; others wait.
    """
    free, kept = np.ones(len(xyz), bool), []
    for place, odds, looked in zip(places.xyz, places.odds, searched, strict=True):
        close = near(xyz, place, confirmation.reach)
        if close.any():
            chosen = int(np.where(close, gain, -np.inf).argmax())
            kept.append((xyz[chosen], rules.memory * odds + gain[chosen] - rules.drift, chosen))
            free &= ~close
        else:
            fallen = rules.memory * odds - confirmation.absent - rules.drift
            kept.append((place, fallen if looked else odds, -1))
    for _ in range(BIRTHS):
        if not free.any():
            break
        chosen = int(np.where(free, gain, -np.inf).argmax())
        kept.append((xyz[chosen], gain[chosen] - rules.drift, chosen))
        free &= ~near(xyz, xyz[chosen], confirmation.reach)
    return _apart(sorted(kept, key=lambda place: -place[1]), rules.bound, confirmation.reach)


def near(xyz: Array, place: Array, reach: float) -> Array:
    """Which of N places are near one: (N, 3) m -> (N,) bool."""
    off = xyz - place
    return np.asarray(np.vecdot(off, off) < reach * reach)


def certain(places: Places, confirmation: Confirmation, alike: int, already: bool, complete: bool) -> bool:
    """Whether the likeliest place is the target's: sure by itself, or far ahead of its rivals.

    alike: targets that look the same and are sought, too; each may be at one of the next places; already:
    whether it was so in the frame before; then it stays while more speaks for it than against it; complete:
    whether three views that all make pairs with each other show it; they reduce the required lead by half of
    `margin`, and the required odds by the whole of it.
    """
    odds = places.odds
    if not len(odds):
        return False
    if already:
        return bool(odds[0] > 0)
    bonus = confirmation.margin / 2 * complete
    first = odds[0] + bonus
    lead = first - odds[alike + 1] if len(odds) > alike + 1 else np.inf
    sure = first + bonus >= confirmation.confirmed or (first > 0 and lead >= 2 * confirmation.margin)
    return bool(sure and lead >= confirmation.margin)


def _apart(ordered: list[tuple[Array, float, int]], bound: float, reach: float) -> tuple[Places, Array]:
    """The likeliest places that are no closer than the reach, and their candidates."""
    chosen: list[tuple[Array, float, int]] = []
    for place in ordered:
        if len(chosen) < MOST and not any(near(place[0], other, reach) for other, _, _ in chosen):
            chosen.append(place)
    if not chosen:
        return NOWHERE, np.zeros(0, int)
    xyz, odds, candidate = zip(*chosen, strict=True)
    return Places(np.array(xyz), np.clip(odds, -bound, 2 * bound)), np.array(candidate)

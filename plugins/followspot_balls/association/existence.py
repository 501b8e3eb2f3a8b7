"""Existence of targets as log-odds, and rival positions of targets without a track.

Each frame adds its log-likelihood ratio (a sequential probability ratio test, as in Bar-Shalom's track
confirmation and deletion). The log-odds decay at a constant rate, because evidence ages: people cover balls
and carry them away. They are bounded, so that a long track can still be deleted within a few frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from followspot.messages import Array

MAXIMUM_RIVALS = 4
"""Largest number of rival positions of a target."""
MAXIMUM_NEW = 3
"""Largest number of rival positions of a target that one frame adds."""


class OddsRules(NamedTuple):
    """How evidence changes log-odds, natural logarithms."""

    memory: float
    """Share of the log-odds that a frame keeps."""
    drift: float
    """Decrease in a frame, so that a track without evidence ends."""
    maximum: float
    """Largest log-odds."""
    deletion: float
    """Log-odds below which a track is deleted."""


class Confirmation(NamedTuple):
    """When the position of a target without a track is confirmed."""

    absence: float
    """Additional decrease of its log-odds in a frame without candidates there."""
    odds: float
    """Log-odds from which a position may be the target's."""
    margin: float
    """Smallest lead over a rival position."""
    reach: float
    """m, largest step of a target from frame to frame, and smallest distance between rival positions."""


class Rivals(NamedTuple):
    """Rival positions of one target, the likeliest first."""

    xyz: Array
    """(H, 3) m."""
    odds: Array
    """(H,) log-odds."""


NO_RIVALS = Rivals(np.zeros((0, 3)), np.zeros(0))


class TargetCandidates(NamedTuple):
    """N candidates of one target."""

    xyz: Array
    """(N, 3) m."""
    log_ratio: Array
    """(N,) log-likelihood ratio of a ball there."""
    complete: Array
    """(N,) bool, whether three views that all make pairs with each other show it."""


class Existence(NamedTuple):
    """Evidence for the existence of one target."""

    odds: float
    """Log-odds that the target is where it is tracked."""
    confirmed: bool
    """Whether the position of a target without a track is confirmed."""
    rivals: Rivals
    """Rival positions of a target without a track."""

    @classmethod
    def unknown(cls) -> Existence:
        """Nothing is known."""
        return cls(0.0, False, NO_RIVALS)


def restored(state: Mapping[str, Any]) -> Existence:
    """The existence from its fields as plain values."""
    plain = state["rivals"]
    rivals = Rivals(np.array(plain["xyz"], float).reshape(-1, 3), np.array(plain["odds"], float))
    return Existence(float(state["odds"]), bool(state["confirmed"]), rivals)


def with_track(
    before: Existence, log_ratio: float, xyz: Array, rules: OddsRules, steps: float = 1.0
) -> Existence:
    """The existence of a tracked target one frame later.

    The position of a deleted track becomes a rival position with the log-odds of the track. Frames in quick
    succession bring less new evidence each, so such a frame counts as a fraction of a step.
    log_ratio: log-likelihood ratio of the frame; xyz: (3,) m; steps: steps that the frame counts as.
    """
    odds = rules.memory**steps * before.odds + steps * (log_ratio - rules.drift)
    odds = float(max(-rules.maximum, min(odds, rules.maximum)))
    deleted = odds < rules.deletion
    return Existence(odds, False, Rivals(xyz[None].copy(), np.array([odds])) if deleted else NO_RIVALS)


def without_track(
    before: Existence,
    candidates: TargetCandidates,
    center: Array | None,
    alike: int,
    rules: OddsRules,
    confirmation: Confirmation,
) -> tuple[Existence, int]:
    """The existence of a target without a track one frame later, and its confirmed candidate, -1 for none.

    center: (3,) m, the position near which the target was searched, None if it was searched everywhere;
    alike: see :func:`is_confirmed`.
    """
    searched = np.ones(len(before.rivals.odds), bool)
    if center is not None:
        searched = near(before.rivals.xyz, center, confirmation.reach)
    rivals, candidate = updated(before.rivals, candidates, searched, rules, confirmation)
    if not len(candidate) or candidate[0] < 0:
        return Existence(before.odds, False, rivals), -1
    first = int(candidate[0])
    already = before.confirmed and bool(near(rivals.xyz[:1], before.rivals.xyz[0], confirmation.reach)[0])
    confirmed = is_confirmed(rivals, confirmation, alike, already, bool(candidates.complete[first]))
    odds = min(float(rivals.odds[0]), rules.maximum) if confirmed else before.odds
    return Existence(odds, confirmed, rivals), first if confirmed else -1


def updated(
    rivals: Rivals,
    candidates: TargetCandidates,
    searched: Array,
    rules: OddsRules,
    confirmation: Confirmation,
) -> tuple[Rivals, Array]:
    """The rival positions one frame later, and the candidate that continues each: (H,), -1 for none.

    searched: (H,) bool, positions at which candidates could have been found; the log-odds of the others stay.
    """
    xyz, log_ratio = candidates.xyz, candidates.log_ratio
    free, kept = np.ones(len(xyz), bool), []
    for position, odds, was_searched in zip(rivals.xyz, rivals.odds, searched, strict=True):
        close = near(xyz, position, confirmation.reach)
        if close.any():
            chosen = int(np.where(close, log_ratio, -np.inf).argmax())
            kept.append((xyz[chosen], rules.memory * odds + log_ratio[chosen] - rules.drift, chosen))
            free &= ~close
        else:
            decreased = rules.memory * odds - confirmation.absence - rules.drift
            kept.append((position, decreased if was_searched else odds, -1))
    for _ in range(MAXIMUM_NEW):
        if not free.any():
            break
        chosen = int(np.where(free, log_ratio, -np.inf).argmax())
        kept.append((xyz[chosen], log_ratio[chosen] - rules.drift, chosen))
        free &= ~near(xyz, xyz[chosen], confirmation.reach)
    return _separated(sorted(kept, key=lambda rival: -rival[1]), rules.maximum, confirmation.reach)


def near(xyz: Array, center: Array, reach: float) -> Array:
    """Which of N positions are nearer to a centre than the reach: (N, 3) m -> (N,) bool."""
    off = xyz - center
    return np.asarray(np.vecdot(off, off) < reach * reach)


def is_confirmed(
    rivals: Rivals, confirmation: Confirmation, alike: int, already: bool, complete: bool
) -> bool:
    """Whether the likeliest position is confirmed as the target's.

    It needs a lead of `margin` over its rivals and log-odds of `odds`; with twice that lead, log-odds above 0
    are enough. alike: number of other targets without a track that look the same: each may be at one of the
    next positions, so the lead is over the position after these; already: whether the position was confirmed
    in the previous frame: it remains so while its log-odds are positive; complete: whether three views that
    all make pairs with each other show it: this reduces the required lead by half of `margin`, and the
    required odds by the whole of it.
    """
    odds = rivals.odds
    if not len(odds):
        return False
    if already:
        return bool(odds[0] > 0)
    bonus = confirmation.margin / 2 * complete
    first = odds[0] + bonus
    lead = first - odds[alike + 1] if len(odds) > alike + 1 else np.inf
    sure = first + bonus >= confirmation.odds or (first > 0 and lead >= 2 * confirmation.margin)
    return bool(sure and lead >= confirmation.margin)


def _separated(ordered: list[tuple[Array, float, int]], maximum: float, reach: float) -> tuple[Rivals, Array]:
    """The likeliest positions with at least the reach between them, and their candidates."""
    chosen: list[tuple[Array, float, int]] = []
    for rival in ordered:
        if len(chosen) < MAXIMUM_RIVALS and not any(near(rival[0], xyz, reach) for xyz, _, _ in chosen):
            chosen.append(rival)
    if not chosen:
        return NO_RIVALS, np.zeros(0, int)
    positions, odds, candidate = zip(*chosen, strict=True)
    return Rivals(np.array(positions), np.clip(odds, -maximum, 2 * maximum)), np.array(candidate)

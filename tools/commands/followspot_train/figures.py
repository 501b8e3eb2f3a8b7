"""Figures of the cross-validation: recall, headings, threshold, and calibration of the likelihoods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from followspot import Array
from followspot_persons.hog.model import DIRECTIONS, trusted
from followspot_train.pictures import Person
from followspot_train.recipe import Trial

RATE = 1e-3
"""False positives per window at which recall is reported."""
THRESHOLD_RATE = 1e-4
"""False positives per window at the detector's own threshold."""
ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
FACTORS = np.geomspace(0.3, 3.0, 15)
MISTAKEN = np.array([0.001, 0.003, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2])


def threshold(trials: Sequence[Trial]) -> float:
    """Score that one of 1 / THRESHOLD_RATE windows of strange backgrounds exceeds."""
    scores = np.concatenate([trial.background for trial in trials])
    return score_at(scores, sum(trial.searched for trial in trials), THRESHOLD_RATE)


def score_at(scores: Array, searched: int, rate: float) -> float:
    """The score that a share `rate` of the searched windows exceeds; scores: of windows that have one."""
    allowed = int(searched * rate)
    return float(np.sort(scores)[::-1][allowed]) if allowed < len(scores) else float(scores.min(initial=0.0))


def recall(trials: Sequence[Trial], persons: Sequence[Person], rate: float) -> dict[str, Any]:
    """Share of held-out persons found at a rate of false positives: of numbered bodies, and of others."""
    found: dict[bool, list[Array]] = {True: [], False: []}
    for trial in trials:
        least = score_at(trial.background, trial.searched, rate)
        hit = (trial.linear > 0) & (trial.judgement.score > least)
        known = np.array([persons[number].body >= 0 for number in trial.person], bool)
        for kind in found:
            found[kind].append(hit[known == kind])
    hits = {name: np.concatenate(found[kind]) for name, kind in (("rooms", True), ("streets", False))}
    return {name: {"recall": share(hit), "persons": len(hit)} for name, hit in hits.items() if len(hit)}


def headings(trials: Sequence[Trial], part: str) -> dict[str, float]:
    """Errors of the direction of `torso` or `head` of single windows of strangers, rad in, degrees out."""
    said = np.concatenate([getattr(trial.found, part) for trial in trials])
    true = np.concatenate([getattr(trial, part) for trial in trials])
    known = np.isfinite(true)
    apart = direction(said[known]) - true[known]
    error = np.abs(np.rad2deg((apart + np.pi) % (2 * np.pi) - np.pi))
    return {
        "median_deg": float(np.median(error)),
        "within_22_5": share(error < 22.5),
        "within_45": share(error < 45),
        "flipped": share(error > 135),
    }


def direction(likelihood: Array) -> Array:
    """The likeliest direction, refined by its neighbours: (N, DIRECTIONS) logarithms -> (N,) rad."""
    best = likelihood.argmax(axis=1)[:, None] + np.arange(-2, 3)
    near = np.exp(np.take_along_axis(likelihood, best % DIRECTIONS, axis=1))
    return np.asarray(np.angle((near * np.exp(1j * ANGLES[best % DIRECTIONS])).sum(axis=1)))


def trust(trials: Sequence[Trial], part: str) -> tuple[float, float]:
    """:func:`best_trust` of what the trials said of strangers' `torso` or `head`."""
    said = np.concatenate([getattr(trial.found, part) for trial in trials])
    return best_trust(said, np.concatenate([getattr(trial, part) for trial in trials]))


def best_trust(said: Array, true: Array) -> tuple[float, float]:
    """Scale and error share (see `trusted`) that maximise the likelihood of the true directions.

    said: (N, DIRECTIONS) logits; true: (N,) rad, NaN if unknown.
    """
    known = np.isfinite(true)
    bin_of = np.rint(true[known] / (2 * np.pi) * DIRECTIONS).astype(int) % DIRECTIONS
    rows = np.arange(len(bin_of))

    def likelihood(pair: tuple[float, float]) -> float:
        return float(trusted(said[known], *pair)[rows, bin_of].mean())

    return max(((float(f), float(m)) for f in FACTORS for m in MISTAKEN), key=likelihood)


def share(true: Array) -> float:
    """Share of the rows that are true, 0 if there are none."""
    return float(np.mean(true)) if len(true) else 0.0

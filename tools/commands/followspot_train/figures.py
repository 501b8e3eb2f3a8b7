"""Figures of the cross-validation: recall, headings, threshold, and calibration of the likelihoods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
PRESENCE = 1e-3
"""Odds of a body in a window that the calibration assumes."""
NEWTON, RIDGE = 20, 0.1
"""Steps of the calibration, and its pull towards scores as they are, for a few windows tell little."""
START = np.array([1.0, 0.0])
STEEP = (0.1, 10.0)
"""Limits of the factor of scores."""
ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
FACTORS = np.geomspace(0.3, 3.0, 15)
MISTAKEN = np.array([0.001, 0.003, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2])


def threshold(trials: Sequence[Trial]) -> float:
    """Score that no more than one of 1 / THRESHOLD_RATE windows of strange backgrounds exceeds."""
    return threshold_at(trials, THRESHOLD_RATE)


def threshold_at(trials: Sequence[Trial], rate: float) -> float:
    """Score that a share `rate` of the windows exceeds in the folder where most do, and less in others.

    Rooms that are easy must not hide mistakes in those that are hard.
    """
    folders = {name for trial in trials for name in trial.backgrounds}
    of = [[t.backgrounds[name] for t in trials if name in t.backgrounds] for name in folders]
    return max(
        (
            score_at(np.concatenate([s.scores for s in found]), sum(s.windows for s in found), rate)
            for found in of
        ),
        default=0.0,
    )


def score_at(scores: Array, searched: int, rate: float) -> float:
    """The score that a share `rate` of the searched windows exceeds; scores: of windows that have one."""
    allowed = int(searched * rate)
    return float(np.sort(scores)[::-1][allowed]) if allowed < len(scores) else float(scores.min(initial=0.0))


def steepness(trials: Sequence[Trial]) -> float:
    """The factor that makes differences of scores those of log-odds (Platt 1999): how surely the windows of
    strangers, as a search finds them, are told from those of strange backgrounds.
    """
    backgrounds = [found for trial in trials for found in trial.backgrounds.values()]
    persons = np.concatenate([trial.found.score for trial in trials])
    others = np.concatenate([found.scores for found in backgrounds])
    weight = PRESENCE * sum(found.windows for found in backgrounds) / max(1, len(persons))
    return logistic(persons, others, weight)


def logistic(persons: Array, others: Array, weight: float) -> float:
    """The slope of a logistic regression by Newton steps; weight: of each person, others count once."""
    score = np.concatenate([persons, others])
    inputs = np.column_stack([score, np.ones(len(score))])
    sign = np.repeat([1.0, -1.0], [len(persons), len(others)])
    counts = np.repeat([weight, 1.0], [len(persons), len(others)])

    def loss(line: Array) -> float:
        return float(counts @ np.logaddexp(0, -sign * (inputs @ line)) + RIDGE * np.sum((line - START) ** 2))

    line, length = START, 1.0
    for _ in range(NEWTON):
        wrong = counts / (1 + np.exp(np.clip(sign * (inputs @ line), -50, 50)))
        bend = (inputs * (wrong * (1 - wrong / counts))[:, None]).T @ inputs + 2 * RIDGE * np.eye(2)
        step = np.linalg.solve(bend, inputs.T @ (sign * wrong) - 2 * RIDGE * (line - START))
        length = min(1.0, 2 * length)
        while loss(line + length * step) > loss(line) and length > 1e-6:
            length /= 2
        line = line + length * step
    return float(np.clip(line[0], *STEEP))


def recall(trials: Sequence[Trial], persons: Sequence[Person], rate: float) -> dict[str, Any]:
    """Share of held-out persons found at a rate of false positives, for each folder."""
    hits, folders = [np.zeros(0, bool)], [persons[number].folder for t in trials for number in t.person]
    for trial in trials:
        least = threshold_at([trial], rate)
        hits.append((trial.linear > 0) & (trial.classification.score > least))
    return by_folder(np.concatenate(hits), folders)


def by_folder(hits: Array, folders: Sequence[str]) -> dict[str, Any]:
    """Share and number of persons (N,) that are found, for the folder of each."""
    rows = {name: hits[np.array(folders) == name] for name in dict.fromkeys(folders)}
    return {name: {"recall": share(hit), "persons": len(hit)} for name, hit in rows.items()}


def headings(trials: Sequence[Trial], part: str) -> dict[str, float]:
    """Errors of the direction of `torso` or `head` of single windows of strangers, rad in, degrees out."""
    said = np.concatenate([getattr(trial.found, part) for trial in trials])
    return heading_errors(said, np.concatenate([getattr(trial, part) for trial in trials]))


def heading_errors(said: Array, true: Array) -> dict[str, float]:
    """Errors of directions. said: (N, DIRECTIONS) logarithms; true: (N,) rad, NaN if unknown."""
    known = np.isfinite(true)
    apart = direction(said[known]) - true[known]
    error = np.abs(np.rad2deg((apart + np.pi) % (2 * np.pi) - np.pi))
    return {
        "median_deg": float(np.median(error)),
        "within_22_5": share(error < 22.5),
        "within_45": share(error < 45),
        "flipped": share(error > 135),
    }


def heading_line(part: str, numbers: Mapping[str, float]) -> str:
    """A line of text about the errors of a part of the body."""
    return (
        f"  direction of the {part}: median {numbers['median_deg']:.1f} degrees, within 22.5:"
        f" {100 * numbers['within_22_5']:.0f} %, within 45: {100 * numbers['within_45']:.0f} %,"
        f" flipped: {100 * numbers['flipped']:.1f} %"
    )


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

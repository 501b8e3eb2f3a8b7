"""Kalman filter forward and Rauch-Tung-Striebel smoother backward, for all targets at once (1965)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.tracking import Tracks
from followspot_balls.filtering.motion import Motion, initiated, manoeuvred, predict, transition, update
from followspot_balls.smooth.step import Observation, Step, of_room
from followspot_target_filter.manoeuvre import Bounces

LEAST_SIGMA = 1e-4
"""Lower limit of a tracker's sigma, m."""


class MotionParameters(NamedTuple):
    """How targets move."""

    acceleration: float
    """One sigma, m/s^2."""
    bounces: Bounces
    """Their gate is also that beyond which a late observation is none of a target, and their speed that of a
    target that appears."""


class Filtered(NamedTuple):
    """What is known of T targets from the observations up to a time."""

    time: int
    """ns."""
    prior: Motion
    """Before the observations of this time."""
    motion: Motion
    alive: Array
    """(T,) bool, targets with a motion; the others' rows mean nothing."""
    reported: Array
    """(T,) bool, targets that the tracker reported last."""
    linked: Array
    """(T,) bool, targets whose motion goes on from the step before."""


def nothing(count: int) -> Filtered:
    """Before the first step."""
    none = np.zeros(count, bool)
    empty = Motion(np.zeros((count, 6)), np.tile(np.eye(6), (count, 1, 1)))
    return Filtered(0, empty, empty, none, none, none)


def filtered(past: Filtered, step: Step, model: MotionParameters) -> Filtered:
    """The targets after one more step.

    Targets that the tracker reports are followed. Where it reports none, only an observation that came late
    and agrees with the motion keeps it alive; at times without tracks, targets stay alive.
    """
    seconds = (step.time - past.time) * NANOSECOND if past.alive.any() else 1.0
    reported = past.reported if step.tracks is None else _reported(step.tracks, len(past.alive))
    alive = past.alive.copy() if step.tracks is None else reported.copy()
    fresh = alive & ~past.alive
    motion = prior = predict(past.motion, seconds, model.acceleration)
    for number, seen in enumerate(step.observed):
        new = fresh[seen.target]
        motion = initiated(motion, seen.target[new], seen.xyz[new], seen.noise[new], model.bounces.speed)
        fresh[seen.target[new]] = False
        old = past.alive[seen.target] & (reported[seen.target] | seen.late)
        if seen.late:
            old &= _squared(motion, seen) <= model.bounces.gate**2
        elif number == 0:
            sudden = old & (seen.sure | ~past.reported[seen.target])
            prior = motion = manoeuvred(motion, *_rows(seen, sudden), seconds, model.bounces)
        motion, _ = update(motion, *_rows(seen, old))
        alive[seen.target[old]] = True
    motion = _begun(motion, step.tracks, fresh, model.bounces.speed)
    covariance = np.where(alive[:, None, None], motion.covariance, np.eye(6))
    return Filtered(step.time, prior, Motion(motion.state, covariance), alive, reported, alive & past.alive)


def smoothed(passed: Sequence[Filtered], acceleration: float) -> list[Motion]:
    """The motion at each step from the observations of all: x + C (x' - F x), C = P F^T P'^-1."""
    found = [passed[-1].motion]
    for now, after in zip(passed[-2::-1], passed[:0:-1], strict=True):
        later, prior = found[-1], after.prior
        F, _ = transition((after.time - now.time) * NANOSECOND, acceleration)
        gain = np.linalg.solve(prior.covariance, F @ now.motion.covariance).swapaxes(1, 2)
        gain = np.where(after.linked[:, None, None], gain, 0.0)
        x = now.motion.state + (gain @ (later.state - prior.state)[..., None])[..., 0]
        P = now.motion.covariance + gain @ (later.covariance - prior.covariance) @ gain.swapaxes(1, 2)
        found.append(Motion(x, (P + P.swapaxes(1, 2)) / 2))
    return found[::-1]


def _reported(tracks: Tracks, count: int) -> Array:
    """Targets of the room that have a row, (count,) bool."""
    found = np.zeros(count, bool)
    found[tracks.target[of_room(tracks, count)]] = True
    return found


def _rows(seen: Observation, chosen: Array) -> tuple[Array, Array, Array]:
    return seen.target[chosen], seen.xyz[chosen], seen.noise[chosen]


def _squared(motion: Motion, seen: Observation) -> Array:
    """Squared Mahalanobis distances of observations from where they are expected, (M,)."""
    offset = seen.xyz - motion.xyz[seen.target]
    spread = motion.covariance[seen.target, :3, :3] + seen.noise
    return np.asarray(np.vecdot(offset, np.linalg.solve(spread, offset[..., None])[..., 0]))


def _begun(motion: Motion, tracks: Tracks | None, fresh: Array, speed: float) -> Motion:
    """Targets that appear without an observation begin where the tracker reports them."""
    if tracks is None or not fresh.any():
        return motion
    rows = of_room(tracks, len(fresh))
    rows[rows] = fresh[tracks.target[rows]]
    target, sigma = tracks.target[rows].astype(np.intp), np.maximum(tracks.sigma[rows], LEAST_SIGMA)
    return initiated(motion, target, tracks.xyz[rows], sigma[:, None] ** 2 * np.eye(3), speed)

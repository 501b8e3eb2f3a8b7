"""Bodies that are upright or have any other shape: people fall, lie, crouch and get up.

An interacting multiple model estimator (Bar-Shalom, Li & Kirubarajan 2001, section 11.6.6): each body has one
estimate as an upright person and one of any shape, whose probabilities the boxes decide.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_persons.associate.boxes import tracks as box_tracks
from followspot_persons.associate.boxes.ellipsoid import PLACE, SHAPE, SIZE, SPEED
from followspot_persons.associate.boxes.tracks import BoxTracks
from followspot_persons.associate.motion import step
from followspot_persons.associate.multi_view.views import View
from followspot_persons.associate.rows import Rows


class Shape(NamedTuple):
    """The last four numbers of a state fluctuate about `mean` with these sigmas and forget their past in
    `memory` s (an Ornstein-Uhlenbeck process). moved: sigmas of x, y, z (m) and of the velocity (m/s) that
    are added when a body takes the shape.
    """

    mean: Array
    sigma: Array
    memory: float
    moved: Array


UPRIGHT = Shape(
    np.array([np.log(0.27), np.log(0.86), 0.0, 0.0]),
    np.array([0.3, 0.15, 0.0, 0.0]),
    8.0,
    np.array([0.1, 0.1, 0.2, 0.0, 0.0, 0.0]),
)
"""A round body; its width changes with arms and steps."""
OTHER = Shape(
    np.array([np.log(0.4), np.log(0.3), 0.0, 0.0]),
    np.array([0.3, 0.45, 0.45, 0.45]),
    1.0,
    np.array([0.4, 0.4, 0.5, 0.5, 0.5, 0.0]),
)
"""A body that lies, crouches, falls or gets up."""
SHAPES = (UPRIGHT, OTHER)
SPEED_SIGMA, SPEED_MEMORY = 1.0, 1.0
"""Sigma of the velocity of people, m/s, and the time in which it fades, s."""
FALLS, RISES = 0.1, 0.5
"""How often in a second an upright body takes another shape, and one of another shape gets up."""
NEW = np.array([0.9, 0.1])
"""Probabilities of the shapes of a new body."""
BROAD = 1.0
"""Log-likelihood ratio that is added for bodies of another shape. Their boxes are hardly known beforehand,
which spreads the likelihood over all that may come, but clutter is rare. With 2, falls are followed better,
and people of a crowd take each other's boxes."""
LEAST = 1e-6
"""Probability of a shape that no box can reduce."""


@dataclass(frozen=True, eq=False)
class ShapeMixture(Rows):
    """M bodies, each upright and of another shape. state: (M, 2, 10) as in `boxes.ellipsoid`; covariance:
    (M, 2, 10, 10); shape: (M, 2) probabilities; views: (M,) cameras that saw the body in the last set.
    """

    state: Array
    covariance: Array
    shape: Array
    views: Array

    @classmethod
    def none(cls) -> ShapeMixture:
        """No bodies."""
        return cls(np.zeros((0, 2, SIZE)), np.zeros((0, 2, SIZE, SIZE)), np.zeros((0, 2)), np.zeros(0, int))

    @property
    def each(self) -> BoxTracks:
        """Both estimates of each body in turn, 2 M rows."""
        return BoxTracks(
            self.state.reshape(-1, SIZE), self.covariance.reshape(-1, SIZE, SIZE), np.repeat(self.views, 2)
        )

    def with_each(self, each: BoxTracks) -> ShapeMixture:
        """These bodies with other estimates, 2 M rows."""
        state, covariance = each.state.reshape(-1, 2, SIZE), each.covariance.reshape(-1, 2, SIZE, SIZE)
        return replace(self, state=state, covariance=covariance)

    def with_rows(self, rows: Array, others: ShapeMixture) -> ShapeMixture:
        """These bodies, of which these rows (K,) are others, (K, ...)."""
        columns = {field.name: getattr(self, field.name).copy() for field in fields(self)}
        for name, column in columns.items():
            column[rows] = getattr(others, name)
        return ShapeMixture(**columns)

    @property
    def mean(self) -> BoxTracks:
        """One estimate of each body, with the mean and covariance of the mixture."""
        return BoxTracks(*_merged(self.shape, self.state, self.covariance), self.views)

    @property
    def likeliest(self) -> Array:
        """The state of each body, (M, 10), in its more probable shape."""
        return np.asarray(self.state[np.arange(len(self)), self.shape.argmax(axis=1)])


def new_body(place: Array, sigma: Array) -> ShapeMixture:
    """A body at a place, (3,) m. sigma: (6,) of place, m, and velocity, m/s."""
    state, covariance = np.zeros((1, 2, SIZE)), np.zeros((1, 2, SIZE, SIZE))
    for number, shape in enumerate(SHAPES):
        state[0, number] = *place, 0.0, 0.0, 0.0, *shape.mean
        covariance[0, number] = np.diag(np.append(sigma, shape.sigma) ** 2)
    return ShapeMixture(state, covariance, NEW[None], np.zeros(1, int))


def predicted(bodies: ShapeMixture, seconds: float, floor: Array) -> ShapeMixture:
    """The bodies some time later, some of which may have changed their shape.

    floor: (4,) of its plane, on which bodies usually are.
    """
    changes = -np.expm1(-np.array([FALLS, RISES]) * seconds)
    after, estimates = np.empty_like(bodies.shape), []
    for number, shape in enumerate(SHAPES):
        taken = box_tracks.on_floor(_taking(bodies, 1 - number, shape), floor)
        parts = bodies.shape * np.where(np.arange(2) == number, 1 - changes, changes)
        after[:, number] = parts.sum(axis=1)
        state, covariance = bodies.state.copy(), bodies.covariance.copy()
        state[:, 1 - number], covariance[:, 1 - number] = taken.state, taken.covariance
        estimates.append(_merged(parts / after[:, number, None], state, covariance))
    state, covariance = (np.stack(parts, axis=1) for parts in zip(*estimates, strict=True))
    mixed = replace(bodies, state=state, covariance=covariance, shape=after)
    return _moved(mixed, seconds)


def log_ratios(bodies: ShapeMixture, view: View, box: Array, delay: float) -> Array:
    """Log-likelihood ratios of boxes (N, 4) px being the bodies, (M, N). delay: as of `box_tracks.fitted`."""
    ratio, _ = _fitted(bodies, view, box, delay)
    return np.asarray(np.logaddexp(*np.moveaxis(np.log(bodies.shape)[..., None] + ratio, 1, 0)))


def updated(
    bodies: ShapeMixture, rows: Array, view: View, box: Array, probability: Array, delay: float
) -> ShapeMixture:
    """The bodies after the boxes (K, 4) px of these rows (K,). probability: (K,) that a box is the body's."""
    own, number = bodies.where(rows), np.arange(len(rows))
    ratio, edges = (one[number, :, number] for one in _fitted(own, view, box, delay))
    each = box_tracks.updated(
        own.each,
        np.arange(2 * len(rows)),
        view,
        np.repeat(box, 2, axis=0),
        edges.reshape(-1, 4),
        np.repeat(probability, 2),
        delay,
    )
    after = replace(own.with_each(each), shape=_shape_after(own.shape, ratio, probability[:, None]))
    return bodies.with_rows(rows, replace(after, views=own.views + 1))


def _fitted(bodies: ShapeMixture, view: View, box: Array, delay: float) -> tuple[Array, Array]:
    """Ratios (M, 2, N) of boxes being the bodies in each shape, and the edges (M, 2, N, 4) that count."""
    fit = box_tracks.fitted(bodies.each, view, box, delay)
    ratio = fit.ratio.reshape(len(bodies), 2, len(box)) + np.array([0.0, BROAD])[:, None]
    return ratio, fit.edges.reshape(len(bodies), 2, len(box), 4)


def _shape_after(shape: Array, ratio: Array, probability: Array) -> Array:
    """Probabilities of the shapes, (K, 2), after boxes with these log-likelihood ratios, (K, 2).

    probability: (K, 1) that a box is the body's.
    """
    best = ratio.max(axis=1, keepdims=True)
    likelihood = np.where(best > -np.inf, np.exp(ratio - np.where(best > -np.inf, best, 0.0)), 1.0)
    theirs = shape * likelihood
    after = (1 - probability) * shape + probability * theirs / theirs.sum(axis=1, keepdims=True)
    after = np.maximum(after, LEAST)
    return np.asarray(after / after.sum(axis=1, keepdims=True))


def _taking(bodies: ShapeMixture, number: int, shape: Shape) -> BoxTracks:
    """The bodies whose estimate of this number is the last before they took a shape."""
    state, covariance = bodies.state[:, number].copy(), bodies.covariance[:, number].copy()
    state[:, SHAPE] = shape.mean
    covariance[:, SHAPE], covariance[:, :, SHAPE] = 0.0, 0.0
    covariance += np.diag(np.append(shape.moved, shape.sigma) ** 2)
    return BoxTracks(state, covariance, bodies.views)


def _moved(bodies: ShapeMixture, seconds: float) -> ShapeMixture:
    """The bodies some time later, in the shapes that they have."""
    motion = step(seconds, np.array(SPEED_SIGMA), np.array(SPEED_MEMORY))
    F, Q, mean = np.zeros((2, SIZE, SIZE)), np.zeros((2, SIZE, SIZE)), np.zeros((2, SIZE))
    axes, four = np.eye(3), np.eye(4)
    F[:, PLACE, PLACE], F[:, PLACE, SPEED], F[:, SPEED, SPEED] = axes, motion.reach * axes, motion.fade * axes
    Q[:, PLACE, PLACE], Q[:, SPEED, SPEED] = motion.position * axes, motion.velocity * axes
    Q[:, PLACE, SPEED] = Q[:, SPEED, PLACE] = motion.cross * axes
    for number, shape in enumerate(SHAPES):
        fade = np.exp(-seconds / shape.memory)
        F[number, SHAPE, SHAPE], mean[number, SHAPE] = fade * four, (1 - fade) * shape.mean
        Q[number, SHAPE, SHAPE] = (1 - fade**2) * np.square(shape.sigma) * four
    state = mean + (F @ bodies.state[..., None])[..., 0]
    return replace(bodies, state=state, covariance=F @ bodies.covariance @ np.swapaxes(F, 1, 2) + Q)


def _merged(weight: Array, state: Array, covariance: Array) -> tuple[Array, Array]:
    """Means (M, 10) and covariances of mixtures. weight: (M, 2); state: (M, 2, 10)."""
    mean = (weight[..., None] * state).sum(axis=1)
    apart = state - mean[:, None]
    spread = covariance + apart[..., :, None] * apart[..., None, :]
    return mean, (weight[..., None, None] * spread).sum(axis=1)

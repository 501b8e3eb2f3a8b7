"""Bodies that are measured as boxes in pictures; an edge that something hides does not count."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from followspot import Array
from followspot_persons.associate.boxes.ellipsoid import HEIGHT, PLACE, SIZE, SPEED, slopes_of
from followspot_persons.associate.multi_view.views import View
from followspot_persons.associate.rows import Rows

EDGE = np.array([0.05, 0.035, 0.05, 0.05])
"""Sigma of a box's edges, left, upper, right, lower, over the longer side of the body in the picture."""
STANDING = 0.15
"""Sigma of the lower end of a body above the floor, m."""
HIDDEN = 0.1
"""Probability that an edge of a box is not the body's: something hides it, or another body is in the box."""
NEAR = 0.5
"""Distance of edges, over the longer side of the body in the picture, beyond which a box is not compared."""
_OWN = np.array([edges for edges in product((True, False), repeat=4) if sum(edges) >= 2])
"""Hypotheses, (H, 4): the edges that are the body's, two at least."""
_PRIOR = np.log(np.where(_OWN, 1 - HIDDEN, HIDDEN)).sum(axis=1)
_DIAGONAL = np.eye(4)


@dataclass(frozen=True, eq=False)
class BoxTracks(Rows):
    """M bodies. state: (M, 10) of `boxes.ellipsoid`; covariance: (M, 10, 10); views: (M,) cameras that saw
    the body in the last set.
    """

    state: Array
    covariance: Array
    views: Array


@dataclass(frozen=True, eq=False)
class Fit:
    """Bodies (M) against boxes (N). ratio: (M, N) log-likelihood ratios; edges: (M, N, 4) that count."""

    ratio: Array
    edges: Array


def fitted(tracks: BoxTracks, view: View, box: Array, delay: float) -> Fit:
    """Compare bodies with boxes (N, 4) px, whose edges beyond the picture are NaN.

    delay: sigma of the time of exposure, s. Each box is compared whole and without one or two of its edges;
    the likeliest counts.
    """
    there, _, slope = slopes_of(view, tracks.state)
    S, unit = _spread(tracks, there, slope, delay)
    ratio, edges = np.full((len(there), len(box)), -np.inf), np.zeros((len(there), len(box), 4), bool)
    m, n = np.nonzero(_near(there, unit, box))
    if not len(m):
        return Fit(ratio, edges)
    residual = box[n] - there[m]
    valid = np.isfinite(residual)[:, None] & _OWN
    residual = np.where(valid, residual[:, None], 0.0)
    S = np.where(valid[..., :, None] & valid[..., None, :], S[m, None], _DIAGONAL)
    squared = np.vecdot(residual, np.linalg.solve(S, residual[..., None])[..., 0])
    size = np.tile(np.sqrt(view.size * unit[m, None] * [0.5, 1.0]), 2)
    anywhere = np.where(valid, np.log(size / np.sqrt(2 * np.pi))[:, None], 0.0).sum(axis=-1)
    each = anywhere - 0.5 * (squared + np.linalg.slogdet(S)[1]) + _PRIOR
    each[valid.sum(axis=-1) < 2] = -np.inf
    best = each.argmax(axis=1)
    every = np.arange(len(m))
    ratio[m, n], edges[m, n] = each[every, best], valid[every, best]
    return Fit(ratio, edges)


def _near(there: Array, unit: Array, box: Array) -> Array:
    """Whether an edge of each box (N, 4) is near that of each body (M, 4), across and down: (M, N).

    unit: (M,) px, longer sides of the bodies in the picture.
    """
    apart = np.abs(box[None] - there[:, None])
    near = apart < NEAR * unit[:, None, None]
    unknown = np.isnan(box).any(axis=1)
    known = np.asarray(np.isfinite(there).all(axis=1))
    across, down = near[..., 0] | near[..., 2], near[..., 1] | near[..., 3]
    return np.asarray(((across & down) | unknown) & known[:, None])


def updated(
    tracks: BoxTracks,
    rows: Array,
    view: View,
    box: Array,
    edges: Array,
    probability: Array,
    delay: float,
) -> BoxTracks:
    """The bodies in these rows (K,) after their boxes (K, 4) px, of which these edges (K, 4) count.

    probability: (K,) that a box is the body's.
    """
    own = tracks.where(rows)
    there, _, slope = slopes_of(view, own.state)
    S, _ = _spread(own, there, slope, delay)
    edges = edges & np.isfinite(there) & np.isfinite(box)
    H = np.where(edges[..., None], slope, 0.0)
    S = np.where(edges[..., :, None] & edges[..., None, :], S, _DIAGONAL)
    residual = np.where(edges, box - there, 0.0)
    return _corrected(tracks, rows, own, H, S, residual, probability)


def on_floor(tracks: BoxTracks, floor: Array) -> BoxTracks:
    """The bodies, which usually stand on the floor. floor: (4,) a, b, c, d of its plane."""
    state = tracks.state
    half = np.exp(state[:, HEIGHT])
    level = -(state[:, :2] @ floor[:2] + floor[3]) / floor[2]
    residual = level - (state[:, 2] - half)
    H = np.zeros((len(state), 1, SIZE))
    H[:, 0, :2], H[:, 0, 2], H[:, 0, HEIGHT] = floor[:2] / floor[2], 1.0, -half
    S = H @ tracks.covariance @ np.swapaxes(H, 1, 2)
    own = STANDING**2 * np.maximum(1.0, residual**2 / (4 * (S[:, 0, 0] + STANDING**2)))
    S = S + own[:, None, None]
    every = np.arange(len(state))
    return _corrected(tracks, every, tracks, H, S, residual[:, None], np.ones(len(state)), seen=0)


def _spread(tracks: BoxTracks, there: Array, slope: Array, delay: float) -> tuple[Array, Array]:
    """Covariance of expected boxes, (M, 4, 4) px^2, and longer sides of the bodies in the picture, (M,)."""
    unit = np.maximum((there[:, 2:] - there[:, :2]).max(axis=1), 1.0)
    shift = delay * (slope[..., PLACE] @ tracks.state[:, SPEED, None])[..., 0]
    S = slope @ tracks.covariance @ np.swapaxes(slope, 1, 2) + shift[..., :, None] * shift[..., None, :]
    S = S + np.square(unit[:, None] * EDGE)[..., None] * _DIAGONAL
    return S, unit


def _corrected(
    tracks: BoxTracks,
    rows: Array,
    own: BoxTracks,
    H: Array,
    S: Array,
    residual: Array,
    probability: Array,
    seen: int = 1,
) -> BoxTracks:
    """Kalman update of these rows by measurements that are theirs with these probabilities, (K,)."""
    gain = own.covariance @ np.swapaxes(H, 1, 2) @ np.linalg.inv(S)
    move = gain @ residual[..., None]
    theirs = probability[:, None, None]
    state, covariance, views = tracks.state.copy(), tracks.covariance.copy(), tracks.views.copy()
    state[rows] = own.state + (theirs * move)[..., 0]
    less = gain @ S @ np.swapaxes(gain, 1, 2) - (1 - theirs) * move @ np.swapaxes(move, 1, 2)
    covariance[rows] = own.covariance - theirs * less
    views[rows] += seen
    return BoxTracks(state, covariance, views)

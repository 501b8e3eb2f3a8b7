"""Body model of the tracker of people whose detections are boxes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_persons.associate.assignment.affinity import is_body, pair_ratios
from followspot_persons.associate.boxes import shape_mixture
from followspot_persons.associate.boxes import tracks as box_tracks
from followspot_persons.associate.boxes.ellipsoid import PLACE, SPEED, boxes_of
from followspot_persons.associate.boxes.shape_mixture import ShapeMixture
from followspot_persons.associate.boxes.standing import standing_ratios, stands
from followspot_persons.associate.existence import OddsLimits
from followspot_persons.associate.multi_view.triangulation import triangulated
from followspot_persons.associate.multi_view.views import Noise, View, Views

MIDDLE = 0.12
"""Sigma of the middle of a box, and of its ends, on a body, m."""
LARGEST = 0.9
"""Root mean square distance of middle and ends from their middle, m: 2.2 m from end to end."""
WIDE = np.array([0.5, 0.5, 0.5, 1.0, 1.0, 0.5])
"""Sigmas of place, m, and velocity, m/s, of a new body."""
INITIAL_GAIN = 2.6
"""What each detection of a new body adds to its log-odds: three report a person at once."""
ROUNDS = 2
"""How often the boxes of a new body count: the second time near the result of the first."""


@dataclass(frozen=True, eq=False)
class BoxModel:
    """delay: sigma of the time of exposure, s; floor: (4,) its plane."""

    delay: float
    floor: Array
    odds_limits = OddsLimits(initial=-3.0, detection=2.0)

    def initial_gain(self, body: ShapeMixture, views: Views, camera: Array, measured: Array) -> float:
        """What each detection of a new body adds to its log-odds."""
        return INITIAL_GAIN

    def none(self) -> ShapeMixture:
        """No bodies."""
        return ShapeMixture.none()

    def predicted(self, bodies: ShapeMixture, seconds: float) -> ShapeMixture:
        """The bodies some time later."""
        return shape_mixture.predicted(bodies, seconds, self.floor)

    def log_ratios(self, bodies: ShapeMixture, view: View, measured: Array) -> Array:
        """(M, N) of boxes (N, 4) px being these bodies."""
        return shape_mixture.log_ratios(bodies, view, measured, self.delay)

    def updated(
        self, bodies: ShapeMixture, rows: Array, view: View, measured: Array, probability: Array
    ) -> ShapeMixture:
        """The bodies after their boxes (K, 4) px."""
        return shape_mixture.updated(bodies, rows, view, measured, probability, self.delay)

    def pair_ratios(self, views: Views, camera: Array, measured: Array) -> Array:
        """(N, N) of two boxes of different cameras being one body."""
        points = _points(measured)
        ratio = pair_ratios(views, camera, points, Noise(1.0, MIDDLE, self.delay), self._possible)
        a, b = np.nonzero(np.triu(np.isfinite(ratio), 1))
        ratio[a, b] += standing_ratios(views, camera, points[:, 1:], self.floor, a, b)
        ratio[b, a] = ratio[a, b]
        return ratio

    def initiated(self, views: Views, camera: Array, measured: Array) -> ShapeMixture | None:
        """The body of boxes (V, 4) px of different cameras; None if they determine none."""
        points = triangulated(views, camera, _points(measured), Noise(1.0, MIDDLE, self.delay)).xyz
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return None
        first = bodies = shape_mixture.new_body(points[0], WIDE)  # the boxes move an end to the middle
        for _ in range(ROUNDS):
            bodies = self.before_set(replace(first, state=bodies.state))
            for c, box in zip(camera, measured, strict=True):
                bodies = self.updated(bodies, np.zeros(1, int), views.each[c], box[None], np.ones(1))
        return bodies if np.isfinite(bodies.state).all() else None

    def _possible(self, points: Array) -> Array:
        """Whether pairs of boxes may show one person, (P,) bool.

        points: (P, 3, 3) m, where their middles, upper and lower ends meet; NaN for an end that is cut off.
        """
        return np.asarray(is_body(points, LARGEST) | stands(points[:, 1:], self.floor))

    def before_set(self, bodies: ShapeMixture) -> ShapeMixture:
        """The bodies before a set: no camera saw them yet."""
        stood = bodies.with_each(box_tracks.on_floor(bodies.each, self.floor))
        return replace(stood, views=np.zeros_like(bodies.views))

    def shifted(self, bodies: ShapeMixture, seconds: float) -> ShapeMixture:
        """The bodies a little earlier or later, as certain as they are."""
        state = bodies.state.copy()
        state[..., PLACE] += seconds * state[..., SPEED]
        return replace(bodies, state=state)

    def middle(self, bodies: ShapeMixture) -> Array:
        """Middle of each body, (M, 3) m."""
        return bodies.mean.state[:, PLACE]

    def bounding_boxes(self, bodies: ShapeMixture, view: View) -> tuple[Array, Array]:
        """Boxes (M, 4) px about the bodies in a picture, and their depths (M,) m."""
        return boxes_of(view, bodies.likeliest)


def _points(box: Array) -> Array:
    """Middle, upper end and lower end of boxes, (N, 3, 2) px; NaN for what the picture's border cuts off."""
    across = (box[:, 0] + box[:, 2]) / 2
    down = np.stack([(box[:, 1] + box[:, 3]) / 2, box[:, 1], box[:, 3]], axis=1)
    xy = np.stack([np.broadcast_to(across[:, None], down.shape), down], axis=-1)
    xy[np.isnan(xy).any(axis=-1)] = np.nan
    return xy

"""Body model of the tracker of people whose detections are boxes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_persons.associate import box_tracks
from followspot_persons.associate.affinity import pair_ratios
from followspot_persons.associate.box_tracks import (
    HALF_HEIGHT,
    HALF_WIDTH,
    HEIGHT_SIGMA,
    WIDTH_SIGMA,
    BoxTracks,
)
from followspot_persons.associate.ellipsoid import HEIGHT, PLACE, SPEED, WIDTH, boxes_of
from followspot_persons.associate.existence import OddsLimits
from followspot_persons.associate.triangulation import triangulated
from followspot_persons.associate.views import Noise, View, Views

MIDDLE = 0.12
"""Sigma of the middle of a box, and of its ends, on a body, m."""
WIDE = np.array([0.5, 0.5, 0.5, 1.0, 1.0, 0.5, WIDTH_SIGMA, HEIGHT_SIGMA])
"""Sigmas of the state of a new body."""
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class BoxModel:
    """delay: sigma of the time of exposure, s; floor: (4,) its plane."""

    delay: float
    floor: Array
    odds_limits = OddsLimits(initial=-3.0, detection=2.0)

    def none(self) -> BoxTracks:
        """No bodies."""
        return BoxTracks(np.zeros((0, 8)), np.zeros((0, 8, 8)), np.zeros(0, int))

    def predicted(self, tracks: BoxTracks, seconds: float) -> BoxTracks:
        """The bodies some time later."""
        return box_tracks.predicted(tracks, seconds)

    def log_ratios(self, tracks: BoxTracks, view: View, measured: Array) -> Array:
        """(M, N) of boxes (N, 4) px being these bodies."""
        return box_tracks.fitted(tracks, view, measured, self.delay).ratio

    def updated(
        self, tracks: BoxTracks, rows: Array, view: View, measured: Array, probability: Array
    ) -> BoxTracks:
        """The bodies after their boxes (K, 4) px."""
        edges = box_tracks.fitted(tracks.where(rows), view, measured, self.delay).edges
        each = np.arange(len(rows))
        return box_tracks.updated(tracks, rows, view, measured, edges[each, each], probability, self.delay)

    def pair_ratios(self, views: Views, camera: Array, measured: Array) -> Array:
        """(N, N) of two boxes of different cameras being one body."""
        return pair_ratios(views, camera, _points(measured), Noise(1.0, MIDDLE, self.delay))

    def initiated(self, views: Views, camera: Array, measured: Array) -> BoxTracks | None:
        """The body of boxes (V, 4) px of different cameras; None if they determine none."""
        noise = Noise(1.0, MIDDLE, self.delay)
        place = triangulated(views, camera, _points(measured), noise).xyz[0]
        if not np.isfinite(place).all():
            return None
        state = np.zeros((1, 8))
        state[0, PLACE], state[0, WIDTH], state[0, HEIGHT] = place, np.log(HALF_WIDTH), np.log(HALF_HEIGHT)
        tracks = BoxTracks(state, np.diag(WIDE**2)[None], np.zeros(1, int))
        for _ in range(ROUNDS):
            tracks = replace(tracks, covariance=np.diag(WIDE**2)[None], views=np.zeros(1, int))
            tracks = box_tracks.on_floor(tracks, self.floor)
            for c, box in zip(camera, measured, strict=True):
                tracks = self.updated(tracks, np.zeros(1, int), views.each[c], box[None], np.ones(1))
        return tracks if np.isfinite(tracks.state).all() else None

    def before_set(self, tracks: BoxTracks) -> BoxTracks:
        """The bodies before a set: no camera saw them yet."""
        return replace(box_tracks.on_floor(tracks, self.floor), views=np.zeros_like(tracks.views))

    def shifted(self, tracks: BoxTracks, seconds: float) -> BoxTracks:
        """The bodies a little earlier or later, as certain as they are."""
        state = tracks.state.copy()
        state[:, PLACE] += seconds * state[:, SPEED]
        return replace(tracks, state=state)

    def middle(self, tracks: BoxTracks) -> Array:
        """Middle of each body, (M, 3) m."""
        return tracks.state[:, PLACE]

    def bounding_boxes(self, tracks: BoxTracks, view: View) -> tuple[Array, Array]:
        """Boxes (M, 4) px about the bodies in a picture, and their depths (M,) m."""
        return boxes_of(view, tracks.state)


def _points(box: Array) -> Array:
    """Middle, upper end and lower end of boxes, (N, 3, 2) px; NaN for what the picture's border cuts off."""
    across = (box[:, 0] + box[:, 2]) / 2
    down = np.stack([(box[:, 1] + box[:, 3]) / 2, box[:, 1], box[:, 3]], axis=1)
    xy = np.stack([np.broadcast_to(across[:, None], down.shape), down], axis=-1)
    xy[np.isnan(xy).any(axis=-1)] = np.nan
    return xy

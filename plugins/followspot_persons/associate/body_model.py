"""Interface of a kind of bodies, as joints or as boxes, to the tracker of people."""

from __future__ import annotations

from typing import Protocol, Self, TypeVar

from followspot import Array
from followspot_persons.associate.existence import OddsLimits
from followspot_persons.associate.multi_view.views import View, Views


class Bodies(Protocol):
    """States of bodies, one row each."""

    def where(self, keep: Array) -> Self: ...
    def joined(self, other: Self) -> Self: ...
    def __len__(self) -> int: ...


S = TypeVar("S", bound=Bodies)


class BodyModel(Protocol[S]):
    """Motion, measurement and initiation of bodies. A measurement is one row of `measured`, (N, ...)."""

    @property
    def odds_limits(self) -> OddsLimits:
        """Bounds of the log-odds of existence."""

    def initial_gain(self, body: S, views: Views, camera: Array, measured: Array) -> float:
        """What each of the detections (V, ...) of a new body adds to its log-odds."""

    def none(self) -> S:
        """No bodies."""

    def predicted(self, bodies: S, seconds: float) -> S:
        """The bodies some time later."""

    def before_set(self, bodies: S) -> S:
        """The bodies before the detections of a set, of which no camera has seen any."""

    def log_ratios(self, bodies: S, view: View, measured: Array) -> Array:
        """Log-likelihood ratios of detections being the bodies against clutter, (M, N)."""

    def updated(self, bodies: S, rows: Array, view: View, measured: Array, probability: Array) -> S:
        """The bodies after the detections (K, ...) of some of them, (K,).

        probability: (K,) that a detection is the body's, by which it counts (probabilistic data association;
        Bar-Shalom, Willett & Tian 2011, section 3.4).
        """

    def pair_ratios(self, views: Views, camera: Array, measured: Array) -> Array:
        """Log-likelihood ratios of two detections being one body against two, (N, N). camera: (N,)."""

    def initiated(self, views: Views, camera: Array, measured: Array) -> S | None:
        """The body of detections of different cameras, (V,); None if they determine none."""

    def shifted(self, bodies: S, seconds: float) -> S:
        """The bodies a little earlier or later, with the same covariances."""

    def middle(self, bodies: S) -> Array:
        """Middle of each body, (M, 3) m."""

    def bounding_boxes(self, bodies: S, view: View) -> tuple[Array, Array]:
        """Boxes x0, y0, x1, y1 about the bodies in a picture, (M, 4) px, and their depths, (M,) m; NaN if
        there are none.
        """

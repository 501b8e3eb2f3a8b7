"""3D candidates from pairs, and the spheres that they must lie in (Jin & Qian 2008, section 3.5)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from followspot import Array, Field, Latest, Room, Stage
from followspot.tracking import Candidates, Forecast, Pairs
from followspot_balls.detection.hue import BINS
from followspot_balls.detection.search_spheres import SphereParams, in_search_spheres, search_spheres
from followspot_balls.measurement.outline import Stretch, unit_outline
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.pairs.disagreement import UNCOVERED, Disagreement
from followspot_balls.pairs.rays import PairRays
from followspot_balls.pairs.three_views import threefold
from followspot_balls.scene.bounding_planes import facing_planes
from followspot_balls.scene.targets import lost_targets, target_radii, tracked_targets

SAME_COLOR = 0.8
"""Bhattacharyya coefficient of two templates above which colour does not distinguish the targets (eq. 2)."""
SOUGHT = 0.75
"""Part of `plane_tolerance` for a target that is not tracked: light on a plane and a reflector beside it meet
in the plane, a few centimetres below where a ball would lie."""


class Triangulate(Stage):
    """Turn every pair into a 3D candidate; reject those outside the spheres around the forecasts."""

    advice = (
        "check the calibration (`followspot calibrate check`), or widen minimum_area and maximum_area; "
        "targets that only infrared cameras see need marks (`track.marks`)"
    )

    class Params(SphereParams):
        minimum_evident_area: float = Field(
            0.33,
            ge=0,
            unit="1",
            description="smallest blob area of an evident pair over the expected one; raising it avoids "
            "false recoveries, and delays those of partly hidden balls",
        )
        minimum_area: float = Field(
            0.25,
            ge=0,
            unit="1",
            description="smallest blob area over the expected one while the target is not tracked; a blob "
            "that makes pairs with both blobs of an evident pair may be smaller; raising it avoids false "
            "recoveries and delays true ones",
        )
        maximum_area: float = Field(
            2.0,
            gt=0,
            unit="1",
            description="largest blob area over the expected one while the target is not tracked; lowering "
            "it avoids mistakes",
        )
        claim_radius: float = Field(
            1.5,
            ge=0,
            unit="1",
            description="distance from a tracked target's image, over the radius of the image, within which "
            "an infrared blob is no evidence of a lost target; raising it avoids false recoveries and delays "
            "true ones",
        )
        plane_tolerance: float = Field(
            0.04,
            unit="m",
            description="largest depth below a plane of a candidate of a tracked target; three quarters of "
            "it for other targets; raising it tolerates inexact planes",
        )

    params: Params

    @cached_property
    def disagreement(self) -> Disagreement:
        """Statistics for the warning at the end; also exists if the run never began."""
        return Disagreement()

    def setup(self) -> None:
        cameras = self.room.cameras.values()
        self.cameras = tuple(self.room.cameras)
        self.rays = PairRays(self.room)
        self.centers = self.rays.centers
        self.planes = facing_planes(self.room, self.centers)
        self.radii = target_radii(self.room)
        self.projection = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.infrared = np.array([c.kind == "infrared" for c in cameras], bool)
        self.focal = np.array([c.matrix[0, 0] for c in cameras])
        self.unit_outline, self.stretch = unit_outline(self.room), Stretch(self.room)
        self.ahead = np.array([c.rotation[2] for c in cameras]).reshape(-1, 3)
        self.radii2 = np.square(self.radii)
        self.alike = alike(self.room)
        self.ambiguous = bool(self.alike.any())

    def process(self, pairs: Pairs, forecast: Latest[Forecast] = None) -> Candidates:
        pairs = numbered(pairs, self.cameras)
        xyz = self.rays.points(pairs)
        shares = self.unit_shares(xyz, pairs)
        tracked = tracked_targets(forecast, len(self.radii))
        targets = pairs.targets & self.within(xyz, pairs, forecast) & self.above_planes(xyz, tracked)
        smaller = np.minimum(shares[:, :1], shares[:, 1:])
        whole = smaller >= self.params.minimum_evident_area * self.radii2
        if np.count_nonzero(tracked) < tracked.size:
            targets &= self.unclaimed(pairs, forecast)
            largest = (shares / self.stretched(xyz, pairs)).max(axis=1)
            targets &= tracked | self.plausible(shares, largest, pairs, targets & ~tracked, whole)
            if np.count_nonzero(tracked) < len(tracked) - 1:
                targets &= ~(nameless(pairs)[:, None] & lost_targets(forecast, len(self.radii)))
        evident = pairs.evident & (targets & whole).any(axis=1)
        rows = np.asarray(targets.any(axis=1)).nonzero()[0]
        candidates = Candidates(
            cameras=pairs.cameras,
            xyz=xyz.take(rows, axis=0),
            view=pairs.view.take(rows, axis=0),
            blob=pairs.blob.take(rows, axis=0),
            xy=pairs.xy.take(rows, axis=0),
            area=pairs.area.take(rows, axis=0),
            epipolar=pairs.epipolar.take(rows),
            labelled=pairs.labelled.take(rows),
            confirmed=pairs.confirmed.take(rows),
            evident=evident.take(rows),
            targets=targets.take(rows, axis=0),
            clutter=pairs.clutter.take(rows, axis=0),
        )
        if self.disagreement.due():
            uncovered = smaller >= UNCOVERED * self.radii2
            self.disagreement.add(candidates, tracked & uncovered.take(rows, axis=0))
        return candidates

    def close(self) -> None:
        """Warn the user if the cameras contradict each other."""
        if text := self.disagreement.warning():
            self.context.warn(text)

    def within(self, xyz: Array, pairs: Pairs, forecast: Forecast | None) -> Array:
        """Which points lie in which target's search sphere: (N, T) bool."""
        alike = self.alike if self.ambiguous else None
        return in_search_spheres(xyz, pairs.labelled, forecast, self.radii, self.reach, alike)

    def reach(self, forecast: Forecast) -> Array:
        """Radius of each target's search sphere, (T,) m."""
        return search_spheres(forecast, self.params.minimum_search_radius, self.params.search_radius_scale)

    def above_planes(self, xyz: Array, tracked: Array) -> Array:
        """Which targets could lie there without sinking into a plane: (N, T) bool. tracked: (T,) bool."""
        height = xyz @ self.planes[:, :3].T + self.planes[:, 3]
        depth = np.where(tracked, 1.0, SOUGHT) * self.params.plane_tolerance
        return np.asarray(height.min(axis=1, initial=np.inf)[:, None] >= self.radii - depth)

    def unclaimed(self, pairs: Pairs, forecast: Forecast | None) -> Array:
        """Which pairs may be a target's although others are tracked: (N, T) bool.

        An infrared blob at the forecast of a tracked target is that target, and no evidence of a lost one.
        """
        count = len(self.radii)
        lost, tracked = lost_targets(forecast, count), tracked_targets(forecast, count)
        if forecast is None or not (lost.any() and tracked.any()):
            return np.ones(pairs.targets.shape, bool)
        image = self.projection[:, :, :3] @ forecast.xyz[tracked].T + self.projection[:, :, 3:]
        depth = np.where(image[:, 2] > 0, image[:, 2], np.nan)
        outline = self.params.claim_radius * self.focal[:, None] * self.radii[tracked] / depth
        offset = pairs.xy[..., None] - (image[:, :2] / depth[:, None])[pairs.view]
        inside = np.hypot(offset[:, :, 0], offset[:, :, 1]) <= outline[pairs.view]
        claimed = (inside.any(axis=2) & self.infrared[pairs.view]).any(axis=1)
        return np.asarray(~(claimed[:, None] & lost))

    def unit_shares(self, xyz: Array, pairs: Pairs) -> Array:
        """Share of the outline of a ball of unit radius there that both blobs show: (N, 2).

        Over the squared radius of a target it is the share of the target's outline.
        """
        offset = xyz[:, None] - self.centers.take(pairs.view, axis=0)
        distance2 = np.vecdot(offset, offset)
        return np.asarray(pairs.area * distance2 / self.unit_outline.take(pairs.view))

    def stretched(self, xyz: Array, pairs: Pairs) -> Array:
        """How much larger than these outlines the lenses draw balls there: (N, 2)."""
        offset = xyz[:, None] - self.centers.take(pairs.view, axis=0)
        depth = np.vecdot(offset, self.ahead.take(pairs.view, axis=0))
        return self.stretch.at(pairs.view, np.vecdot(offset, offset) / np.square(depth))

    def plausible(self, shares: Array, largest: Array, pairs: Pairs, sought: Array, whole: Array) -> Array:
        """Which pairs have the size of a target that is not tracked at their distance: (N, T) bool.

        A tracked ball may be partly hidden. Another one must be well visible to two cameras at least: a blob
        that makes pairs with both blobs of an evident pair may be small.
        shares: (N, 2), of :meth:`unit_shares`; largest: (N,), the larger share of each pair without the
        stretching of the lens; sought: (N, T) bool, pairs that may show a target that is not tracked; whole:
        (N, T) bool, pairs whose blobs are both large enough for an evident pair.
        """
        sought = sought & (largest[:, None] <= self.params.maximum_area * self.radii2)
        large = shares.min(axis=1)[:, None] >= self.params.minimum_area * self.radii2
        evident = sought & whole & pairs.evident[:, None]
        return np.asarray(sought & (large | threefold(pairs, sought, evident)))


def nameless(pairs: Pairs) -> Array:
    """Pairs of a room without colour cameras, which do not tell which target they show: (N,) bool.

    They show a lost target only if all others are tracked.
    """
    return np.asarray(pairs.confirmed & ~pairs.labelled)


def alike(room: Room) -> Array:
    """Which other targets have the same colour as each, in some camera: (T, T) bool."""
    targets = list(room.targets.values())
    same = np.zeros((len(targets), len(targets)), bool)
    for name in room.cameras:
        histograms = np.array([t.hue_histogram.get(name, np.zeros(BINS)) for t in targets]).reshape(-1, BINS)
        same |= np.sqrt(histograms) @ np.sqrt(histograms).T > SAME_COLOR
    np.fill_diagonal(same, False)
    return same

"""3D candidates inside the search spheres, and nothing more (Jin & Qian 2008, sections 3.5 and 3.8)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Latest, Stage
from followspot.tracking import Candidates, Forecast, Pairs
from followspot_balls.detection.search_spheres import SphereParams, search_spheres
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.pairs.rays import PairRays
from followspot_balls.scene.targets import lost_targets


class PlainTriangulate(Stage):
    """Turn every pair into a 3D candidate; reject those outside the spheres, as published.

    A lost target has no sphere; only pairs of a colour and an infrared camera may be it.
    """

    class Params(SphereParams):
        """Radii of the spheres."""

    params: Params

    def setup(self) -> None:
        self.cameras = tuple(self.room.cameras)
        self.rays = PairRays(self.room)

    def process(self, pairs: Pairs, forecast: Latest[Forecast] = None) -> Candidates:
        pairs = numbered(pairs, self.cameras)
        xyz = self.rays.points(pairs)
        targets = pairs.targets & self.within(xyz, pairs.confirmed, forecast)
        rows = np.flatnonzero(targets.any(axis=1))
        return Candidates(
            cameras=pairs.cameras,
            xyz=xyz[rows],
            view=pairs.view[rows],
            blob=pairs.blob[rows],
            xy=pairs.xy[rows],
            area=pairs.area[rows],
            epipolar=pairs.epipolar[rows],
            labelled=pairs.labelled[rows],
            confirmed=pairs.confirmed[rows],
            evident=pairs.evident[rows],
            targets=targets[rows],
            clutter=pairs.clutter[rows],
        )

    def within(self, xyz: Array, confirmed: Array, forecast: Forecast | None) -> Array:
        """Which points may be which target by their place: (N, T) bool.

        xyz: (N, 3) m, NaN for rays that do not meet; confirmed: (N,) bool.
        """
        lost = lost_targets(forecast, len(self.room.targets))
        real = ~np.isnan(xyz[:, :1])
        anywhere = real & confirmed[:, None] & lost
        if forecast is None or lost.all():
            return np.asarray(anywhere)
        p = self.params
        radius = search_spheres(forecast, p.minimum_search_radius, p.search_radius_scale)
        distance = np.linalg.norm(xyz[:, None] - forecast.xyz, axis=2)
        return np.asarray(anywhere | (~lost & (distance <= radius)))

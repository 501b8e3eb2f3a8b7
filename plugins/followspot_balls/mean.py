"""Fusion of 3D candidates by their plain mean: the baseline of Jin & Qian 2008, section 3.6, figure 3."""

from __future__ import annotations

import numpy as np

from followspot import Latest, Stage
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.scene.targets import lost_targets


class Mean(Stage):
    """The mean of all candidates of each target; for a lost target those of colour-infrared pairs."""

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Positions:
        lost = lost_targets(forecast, candidates.targets.shape[1])
        used = candidates.targets.T & (candidates.confirmed | ~lost[:, None])
        target = np.flatnonzero(used.any(axis=1))
        used = used[target]
        xyz = used @ candidates.xyz / used.sum(axis=1)[:, None]
        return Positions.fused(candidates, target, used, xyz)

"""Measured positions of the room's targets from points that have their names."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.errors import did_you_mean
from followspot.points import Points3D
from followspot.tracking import LOST, Forecast, Positions

MOST_TOLD = 20
"""Strange labels that the user is told of."""


class Targets(Stage):
    """Take each point whose label is the name of a target of the room as the target's position.

    If a target has several points, the one nearest to its forecast counts. Without a forecast, the one that
    most cameras saw counts, and among these the one with the best score.
    """

    class Params(StageParams):
        maximum_step: float = Field(
            0.5,
            gt=0,
            unit="m",
            description="largest distance between the forecast and a point that is taken for the target; "
            "raising it lets targets jump",
        )

    params: Params

    def setup(self) -> None:
        self.number = {name: number for number, name in enumerate(self.room.targets)}
        self.strange: set[str] = set()

    def process(self, points: Points3D, forecast: Latest[Forecast] = None) -> Positions:
        target = np.array([self.number_of(label) for label in points.labels], "i4")[points.label]
        apart = self.apart(points.xyz, target, forecast)
        # the last key is the first to sort by
        order = np.lexsort([-points.score, -points.views, np.where(np.isnan(apart), 0.0, apart), target])
        named = order[(target[order] >= 0) & ~(apart[order] > self.params.maximum_step)]
        rows = named[np.unique(target[named], return_index=True)[1]]
        count = len(rows)
        return Positions(
            target=target[rows],
            xyz=points.xyz[rows],
            covariance=points.covariance[rows],
            support=np.maximum(points.views[rows], 1).astype("i4"),
            confirmed=np.ones(count, bool),
            evident=np.ones(count, bool),
            iterations=np.zeros(count, "i4"),
            predicted=np.zeros(count, bool),
        )

    def number_of(self, label: str) -> int:
        """Number of the target, -1 if the label is no target's; then the user is told once."""
        if label not in self.number and label not in self.strange and len(self.strange) < MOST_TOLD:
            self.strange.add(label)
            hint = did_you_mean(label, self.number, "targets")
            self.context.warn(f'points with the label "{label[:80]}" are no target of the room; {hint}')
        return self.number.get(label, -1)

    def apart(self, xyz: Array, target: Array, forecast: Forecast | None) -> Array:
        """Distance of each point from the forecast of its target, (N,) m; NaN without a forecast."""
        apart = np.full(len(target), np.nan)
        if forecast is not None and len(forecast.state):
            known = (target >= 0) & (forecast.state[target] != LOST)
            apart[known] = np.linalg.norm(xyz[known] - forecast.xyz[target[known]], axis=1)
        return apart

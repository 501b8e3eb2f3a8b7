"""The part that the fusions of all views share: validation of their positions."""

from __future__ import annotations

from abc import ABC
from functools import cached_property
from typing import Any

import numpy as np

from followspot import Array, Stage
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.association.infrared_only import Colorless, ColorlessParams
from followspot_balls.association.recovery import Recovery, RecoveryParams
from followspot_balls.fusion.blob_assignment import Claims
from followspot_balls.fusion.view_votes import ViewVotes, VoteParams
from followspot_balls.measurement.blob_table import BlobTable
from followspot_balls.measurement.center_precision import Outlines
from followspot_balls.scene.bounding_planes import facing_planes, raised
from followspot_balls.scene.targets import target_radii


class Fusion(Stage, ABC):
    """Base of fusions that check positions of lost targets by all views, and end tracks without colour."""

    advice = (
        "either no pair is evidence of a target: a colour and an infrared camera must see it at the same "
        "time, or two cameras if all are of one kind; or all views contradict the pairs, then the stage warns"
    )

    class Params(VoteParams, RecoveryParams, ColorlessParams):
        """The errors of blobs, and the evidence of all views that a position needs."""

    params: Params

    def setup(self) -> None:
        self.cameras = tuple(self.room.cameras)
        cameras = self.room.cameras.values()
        self.bounds = facing_planes(self.room, np.array([c.center for c in cameras]).reshape(-1, 3))
        self.radii = target_radii(self.room)
        self.colorless = Colorless(self.room, self.params)
        self.votes = ViewVotes(self.room, self.params)
        self.outlines = Outlines(self.room)

    @cached_property
    def recovery(self) -> Recovery:
        """The check of positions by all views; also there if the stage is closed before it is set up."""
        return Recovery(self.room, self.params)

    def claims(self, table: BlobTable, target: Array, lost: Array) -> Claims:
        """The blobs of a frame as those of targets (M,). lost: (M,) bool, which have no forecast."""
        sizes = self.outlines.at_unit_depth(table.xy, table.area)
        return Claims(table.xy, table.targets[target], sizes, self.radii[target], lost)

    def validated(self, positions: Positions, candidates: Candidates, forecast: Forecast | None) -> Positions:
        """The positions that the views do not contradict, raised above planes into which they sink."""
        positions = raised(positions, self.bounds, self.radii, self.params.plane_sigma)
        likely = self.recovery.accepted(positions, candidates, forecast)
        self.recovery.refusals.found[likely.target] = True
        return self.colorless.bounded(likely, candidates, forecast)

    def close(self) -> None:
        """Warn the user of targets that were never found because the views contradict their pairs."""
        if text := self.recovery.refusals.warning():
            self.context.warn(text)

    def state(self) -> Any:
        return {
            "since": self.colorless.since,
            "odds": self.recovery.odds,
            "xyz": self.recovery.xyz,
            "refusals": self.recovery.refusals.state(),
        }

    def restore(self, state: Any) -> None:
        self.colorless.since = np.array(state["since"], float)
        self.recovery.odds = np.array(state["odds"], float)
        self.recovery.xyz = np.array(state["xyz"], float)
        if "refusals" in state:  # not in recordings of before
            self.recovery.refusals.restore(state["refusals"])

"""Candidates of several stages in one message, and whose they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from followspot import Array, Field, Joined, Latest, Stage, StageParams
from followspot.tracking import Blobs, Candidates, Forecast
from followspot_balls.association.color_views import ColorViews
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.scene.targets import lost_targets, target_radii, tracked_targets


class Gather(Stage):
    """Put the candidates of depth cameras, and of pairs of other cameras, into one message.

    What a depth camera found has no name. A blob of a colour camera at the same place gives it one. Without a
    name it may be a lost target only if all others of that radius are tracked.
    """

    advice = (
        "what depth cameras alone see has no name: say where each target is at the beginning "
        "(`track.marks`), and check places that were told"
    )

    class Params(StageParams):
        label_radius: float = Field(
            1.0,
            gt=0,
            unit="1",
            description="distance of a colour blob from a candidate's image up to which it names it, over "
            "the ball's radius; raising it tolerates bad calibration",
        )

    params: Params

    def setup(self) -> None:
        self.cameras = tuple(self.room.cameras)
        self.color = ColorViews(self.room)
        self.radii = target_radii(self.room)
        targets = np.zeros((0, len(self.radii)), bool)
        self.nothing = Candidates.empty(cameras=self.cameras, targets=targets)

    def process(
        self,
        candidates: Joined[Candidates],
        blobs: Joined[Blobs] = (),
        forecast: Latest[Forecast] = None,
    ) -> Candidates:
        parts = [numbered(part, self.cameras) for part in candidates if len(part.xyz)]
        if not parts:
            return self.nothing
        if len(parts) == 1:
            return self.named(parts[0], blobs, forecast)
        columns = {name: np.concatenate([getattr(p, name) for p in parts]) for name in Candidates.array_names}
        return self.named(Candidates(cameras=self.cameras, **columns), blobs, forecast)

    def named(self, found: Candidates, blobs: Sequence[Blobs], forecast: Forecast | None) -> Candidates:
        """The candidates; those of depth cameras with the names that colour gives them, or none."""
        alone = (found.view[:, 0] == found.view[:, 1]) & ~found.labelled
        if not alone.any():
            return found
        targets = found.targets & self.color.shown(found.xyz, blobs, self.params.label_radius)
        labelled = alone & targets.any(axis=1)
        unnamed = found.targets & (
            ~lost_targets(forecast, len(self.radii)) | self.known_by_exclusion(forecast)
        )
        targets = np.where(labelled[:, None], targets, np.where(alone[:, None], unnamed, found.targets))
        found = replace(found, targets=targets, labelled=found.labelled | labelled)
        rows = np.flatnonzero(targets.any(axis=1))
        return found if len(rows) == len(targets) else found.where(rows)

    def known_by_exclusion(self, forecast: Forecast | None) -> Array:
        """Which targets are the only one of their radius that is not tracked: (T,) bool."""
        absent = ~tracked_targets(forecast, len(self.radii))
        alike = self.radii[:, None] == self.radii
        return np.asarray(absent & (alike @ absent.astype(int) == 1))

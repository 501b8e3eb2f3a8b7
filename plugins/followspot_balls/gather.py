"""Merges the candidates of several stages, and names those of depth cameras by colour."""

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
    """Merge the candidates of depth cameras and those of pairs of other cameras into one message.

    A depth camera does not tell which target a candidate is. If a blob of a colour camera lies at the image
    of the candidate, the candidate gets the targets of the blob. Without such a blob a candidate can be a
    lost target only if all other targets of the same radius are tracked.
    """

    advice = (
        "depth cameras do not tell which target they see: give the position of each target at the beginning "
        "(`track.marks`), and check the positions that were given"
    )

    class Params(StageParams):
        label_radius: float = Field(
            1.0,
            gt=0,
            unit="1",
            description="largest distance between a candidate's image and a colour blob that names the "
            "candidate, over the ball's radius; raising it tolerates bad calibration",
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
        """The candidates, those of depth cameras with the targets that colour or exclusion allows."""
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

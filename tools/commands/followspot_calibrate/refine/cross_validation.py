"""Whether refining makes cameras better: cross-validated with sightings that took no part in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Progress
from followspot_calibrate.refine.selection import concatenated
from followspot_calibrate.refine.solving import refine
from followspot_calibrate.target_sightings import TargetSightings
from followspot_calibrate.triangulation import triangulate

FOLDS = 3
"""Parts of the sightings of a recording; each is left out once."""
TOLERANCE = 1.1
"""Clips that make the error this many times as large contradict the recording; by chance it is within 5 %."""
Refine = Callable[[TargetSightings], Sequence[Camera]]


@dataclass(frozen=True)
class Comparison:
    """Median reprojection errors of the recording's sightings that were left out, px.

    given: with the cameras of the room file; alone: refined without clips; clips: with them, None if there
    are none.
    """

    given: float
    alone: float
    clips: float | None

    @property
    def use_clips(self) -> bool:
        """Whether the clips agree with the recording."""
        return self.clips is not None and self.clips <= TOLERANCE * self.alone

    @property
    def best(self) -> float:
        """The error of the refined cameras that are chosen, px."""
        return self.clips if self.clips is not None and self.use_clips else self.alone

    @property
    def better(self) -> bool:
        """Whether the refined cameras see the targets better than the given ones."""
        return self.best < self.given


def cross_validate(
    cameras: Sequence[Camera],
    sightings: TargetSightings,
    shown: TargetSightings | None,
    planes: Mapping[str, Array],
    progress: Progress | None = None,
) -> Comparison | None:
    """How well each choice predicts the sightings of a recording that it does not know.

    sightings: of the recording; shown: those of clips. None if too few rows are left to refine cameras.
    """

    def alone(known: TargetSightings) -> Sequence[Camera]:
        return refine(cameras, known, planes, progress).after.cameras

    def with_clips(known: TargetSightings) -> Sequence[Camera]:
        return refine(cameras, concatenated(known, shown), planes, progress).after.cameras

    try:
        return Comparison(
            _left_out(sightings, lambda _: cameras),
            _left_out(sightings, alone),
            None if shown is None else _left_out(sightings, with_clips),
        )
    except FollowspotError:
        return None


def _left_out(sightings: TargetSightings, refined: Refine) -> float:
    """Median error, px, of the sightings that were left out."""
    part = np.arange(len(sightings.pixel)) % FOLDS
    errors = []
    for number in range(FOLDS):
        known = part != number
        cameras = refined(TargetSightings(sightings.pixel[known], sightings.sigma[known]))
        residual = triangulate(cameras, sightings.pixel[~known]).residual
        errors.append(np.hypot(residual[..., 0], residual[..., 1]).ravel())
    error = np.concatenate(errors)
    if not np.isfinite(error).any():
        raise FollowspotError("no place is seen by two cameras")
    return float(np.nanmedian(error))

"""From all views of a board to a camera's lens and its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.room_document.camera import MOST_DISTORTION, MOST_FOCAL
from followspot_calibrate.boards.board import Board
from followspot_calibrate.boards.detection import View
from followspot_calibrate.intrinsics.coverage import Coverage, coverage
from followspot_calibrate.intrinsics.fitting import LEAST_VIEWS, Fit, Lens, NoFit, fit
from followspot_calibrate.intrinsics.selection import diverse, sharp

ROUNDS = 5
"""Rounds of fitting and rejecting."""
OUTLIER = 3.0
"""Error of a view over the median of all views, from which it is rejected..."""
LEAST_OUTLIER = 0.5
"""... unless the error is smaller than this, px."""
FEW_VIEWS = 10
LEAST_COVERED = 0.6
"""Share of the picture."""
LEAST_TILT = 20.0
"""Largest angle between boards, degrees, below which focal length and distance cannot be separated."""
UNSURE = 0.01
"""Sigma of the focal length over the focal length."""
ROUGH = 1.0
"""RMS error from which the board, its description or the lens model is in doubt, px."""
WRONG = 0.02
"""RMS error over the width of the picture, from which what was found is no lens at all."""


@dataclass(frozen=True, eq=False)
class LensCalibration:
    """The lens of one camera, and the views behind it.

    camera: its name; size: px; coverage: of all sharp views; seen: number of pictures with the board;
    blurred, rejected: pictures that were left out, the latter because they contradict the others;
    tilt: largest angle between two boards, degrees; warnings: what to do better next time.
    """

    camera: str
    size: tuple[int, int]
    model: Lens
    fit: Fit
    coverage: Coverage
    seen: int
    blurred: tuple[int, ...]
    rejected: tuple[int, ...]
    tilt: float
    warnings: tuple[str, ...]


def calibrate_lens(
    camera: str, views: Sequence[View], board: Board, size: tuple[int, int], model: Lens
) -> LensCalibration:
    """The lens from sharp and diverse views that agree with each other. Raises NoFit."""
    usable = sharp(views)
    found, rejected = agreeing(diverse(usable, board, size), board, size, model)
    check_plausible(found, size, model)
    covered = coverage(usable, size)
    tilt = tilt_of(found)
    return LensCalibration(
        camera,
        size,
        model,
        found,
        covered,
        len(views),
        tuple(view.frame for view in views if view not in usable),
        rejected,
        tilt,
        tuple(warnings_of(found, covered, tilt)),
    )


def agreeing(
    views: Sequence[View], board: Board, size: tuple[int, int], model: Lens
) -> tuple[Fit, tuple[int, ...]]:
    """The fit to views without outliers, and the numbers of the rejected views. Raises NoFit."""
    found = fit(views, board, size, model)
    for _ in range(ROUNDS):
        error = found.per_view
        good = error <= max(OUTLIER * float(np.median(error)), LEAST_OUTLIER)
        if good.all() or good.sum() < LEAST_VIEWS:
            break
        found = fit([view for view, keep in zip(found.views, good, strict=True) if keep], board, size, model)
    kept = {view.frame for view in found.views}
    return found, tuple(view.frame for view in views if view.frame not in kept)


def check_plausible(found: Fit, size: tuple[int, int], model: Lens) -> None:
    """Raises NoFit if the search ran away to numbers that a room file does not take, or the error is huge."""
    largest = float(np.abs(found.distortion).max())
    bounded = largest <= MOST_DISTORTION and np.abs(found.matrix).max() <= MOST_FOCAL
    if not bounded or found.rms > WRONG * size[0]:
        raise NoFit(
            f"no lens explains the views: the best has a focal length of {found.matrix[0, 0]:.3g} px, "
            f"distortion coefficients up to {largest:.2g} and an error of {found.rms:.0f} px; "
            f"is --model {model} right?"
        )


def tilt_of(found: Fit) -> float:
    """Largest angle between the normals of two boards, degrees."""
    normals = found.rotation[:, :, 2]
    return float(np.degrees(np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0))))


def warnings_of(found: Fit, covered: Coverage, tilt: float) -> list[str]:
    """Warnings about parameters that the views leave open, each with its remedy."""
    notes = []
    if len(found.views) < FEW_VIEWS:
        notes.append(
            f"only {len(found.views)} views are usable: show the board in {FEW_VIEWS} places or more"
        )
    if covered.share < LEAST_COVERED:
        where = ", ".join(covered.missing)
        notes.append(f"only {covered.share:.0%} of the picture is covered: show the board in its {where}")
    if tilt < LEAST_TILT:
        notes.append(
            f"all boards are parallel within {tilt:.0f} degrees, which leaves the focal length open "
            f"({found.matrix[0, 0]:.0f} +- {found.sigma[0]:.0f} px, more if the model is not quite right): "
            "tilt the board by 30 to 45 degrees, to all sides"
        )
    sigma = found.sigma[0] / found.matrix[0, 0]
    if sigma > UNSURE:
        notes.append(f"the focal length is known to {sigma:.1%} only: show the board nearer and more tilted")
    if found.rms > ROUGH:
        notes.append(
            f"the error of {found.rms:.1f} px is large: is the board flat, --board right, --model right?"
        )
    return notes

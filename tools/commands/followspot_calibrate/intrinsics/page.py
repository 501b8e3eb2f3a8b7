"""The page of `followspot calibrate intrinsics`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from followspot_calibrate.intrinsics.calibration import LensCalibration
from followspot_calibrate.report import Page, Section, coverage, plain_table

HEAD = (
    "camera",
    "model",
    "views",
    "blurred",
    "outliers",
    "RMS px",
    "focal px",
    "centre px",
    "covered",
    "tilt",
)


def page_of(room: str, done: Mapping[str, LensCalibration], notes: Mapping[str, Sequence[str]]) -> Page:
    """The lenses, and for each camera its sightings of the board's corners and their residuals.

    notes: camera -> warnings.
    """
    warnings = [f"{name}: {text}" for name, texts in notes.items() for text in texts]
    worst = max((lens.fit.rms for lens in done.values()), default=0.0)
    lenses = "1 lens" if len(done) == 1 else f"{len(done)} lenses"
    doubted = [name for name, texts in notes.items() if texts]
    return Page(
        f"Lenses of {room}",
        "look" if warnings else "good",
        f"{lenses}, at most {worst:.2f} px RMS",
        warnings,
        [
            plain_table("Lenses", HEAD, [_row(lens) for lens in done.values()], marked=doubted),
            *map(_pictures, done.values()),
        ],
    )


def _row(lens: LensCalibration) -> list[str]:
    found = lens.fit
    focal, sigma = found.matrix[0, 0], found.sigma
    return [
        lens.camera,
        lens.model,
        f"{len(found.views)} of {lens.seen}",
        str(len(lens.blurred)),
        str(len(lens.rejected)),
        f"{found.rms:.2f}",
        f"{focal:.1f} ± {sigma[0]:.1f}",
        f"{found.matrix[0, 2]:.1f}, {found.matrix[1, 2]:.1f}",
        f"{100 * lens.coverage.share:.0f} %",
        f"{lens.tilt:.0f}°",
    ]


def _pictures(lens: LensCalibration) -> Section:
    """Corners and residuals of the views that the lens rests on."""
    pixel = np.concatenate([view.pixel for view in lens.fit.views])
    shown = coverage(lens.camera, lens.size, pixel, np.concatenate(lens.fit.residual))
    return replace(shown, note="Corners of the board, and their distances from those that the lens predicts.")

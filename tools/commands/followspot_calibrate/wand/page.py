"""The page of `followspot calibrate wand`."""

from __future__ import annotations

import numpy as np

from followspot import Room
from followspot_calibrate.report import Page, calibration_page, plain_table
from followspot_calibrate.wand.result import Calibrated, notes_of, shared_points

SHARED_NOTE = "Points that both cameras saw; the more, the better the two are tied together."


def page_of(room: Room, result: Calibrated) -> Page:
    """The cameras, the points that pairs share, and the residuals of the wand's points in each camera.

    room: before the calibration; its planes are shown if its frame of reference stayed.
    """
    adjusted = result.solved.adjusted
    return calibration_page(
        f"Wand of {room.name}",
        "look" if result.warnings else "good",
        f"{len(result.cameras)} cameras, {result.mean_px:.2f} px on average",
        list(result.cameras.values()),
        result.solved.sightings.pixel,
        result.points,
        np.where(adjusted.used[..., None], adjusted.residual, np.nan),
        planes=room.planes if result.alignment.method == "centers" else None,
        warnings=result.warnings,
        more=[
            plain_table("Figures", ("", ""), notes_of(result)),
            plain_table("Pairs", ("", *result.cameras), shared_points(result), note=SHARED_NOTE),
        ],
    )

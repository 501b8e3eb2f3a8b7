"""The page of `followspot calibrate wand`."""

from __future__ import annotations

import numpy as np

from followspot import Room
from followspot_calibrate.report import Page, calibration_page, plain_table
from followspot_calibrate.wand.result import Calibrated, shared_points, told

SHARED_NOTE = "Points that both cameras saw; the more, the better the two are tied together."


def page_of(room: Room, result: Calibrated) -> Page:
    """The cameras, the points that pairs share, and the residuals of the wand's points in each camera.

    room: before the calibration; its planes are shown if its frame of reference stayed.
    """
    settled = result.solved.settled
    return calibration_page(
        f"Wand of {room.name}",
        "look" if result.warnings else "good",
        f"{len(result.cameras)} cameras, {result.mean_px:.2f} px on average",
        list(result.cameras.values()),
        result.solved.sightings.pixel,
        result.points,
        np.where(settled.used[..., None], settled.residual, np.nan),
        planes=room.planes if result.alignment.method == "centers" else None,
        warnings=result.warnings,
        more=[
            plain_table("Figures", ("", ""), told(result)),
            plain_table("Pairs", ("", *result.cameras), shared_points(result), note=SHARED_NOTE),
        ],
    )

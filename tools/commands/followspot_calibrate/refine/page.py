"""The page of `followspot calibrate refine`."""

from __future__ import annotations

import numpy as np

from followspot import Room
from followspot_calibrate.refine.solving import Refinement
from followspot_calibrate.refine.text import HEAD, cells, verdict
from followspot_calibrate.report import Page, calibration_page, plain_table

NOTE = "Against the room file as it was, whose camera centres hold the frame of reference."


def page_of(room: Room, found: Refinement) -> Page:
    """The changes and the remaining errors."""
    after = found.after
    return calibration_page(
        f"Refinement of {room.name}",
        "good",
        verdict(found),
        after.cameras,
        found.pixel,
        after.points,
        np.where(after.used[..., None], after.residual, np.nan),
        planes=found.planes,
        more=[plain_table("Changes", HEAD, cells(found), note=NOTE)],
    )

"""The page of `followspot calibrate planes`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.planes.fit import FittedPlane
from followspot_calibrate.planes.marks import Marks
from followspot_calibrate.planes.text import HEAD, cells
from followspot_calibrate.report import Page, calibration_page, plain_table
from followspot_calibrate.similarity import Similarity


def page_of(
    room: str,
    cameras: Mapping[str, Camera],
    planes: Mapping[str, Array],
    marks: Marks,
    fits: Sequence[FittedPlane],
    motion: Similarity | None,
    warnings: Sequence[str],
) -> Page:
    """The planes, the residuals of their points in each camera, the room around them.

    cameras, planes: in the frame of the room file; motion: from the frame of the fits to that, if it moved.
    """
    table = plain_table(
        "Planes", HEAD, cells(fits, planes), note="a x + b y + c z + d = 0 with a unit normal, in metres."
    )
    points = np.vstack([fit.found.points for fit in fits])
    summary = ", ".join(f"{fit.name} flat within {fit.rms_mm:.1f} mm (RMS)" for fit in fits)
    return calibration_page(
        f"Planes of {room}",
        "look" if warnings else "good",
        summary,
        list(cameras.values()),
        np.vstack([marks[fit.name].pixel for fit in fits]),
        points if motion is None else motion.points(points),
        np.vstack([np.where(fit.found.used[..., None], fit.found.residual, np.nan) for fit in fits]),
        planes=planes,
        warnings=warnings,
        more=[table],
    )

"""The page of `followspot calibrate board`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot_calibrate.board.solving import BoardCalibration
from followspot_calibrate.report import Page, Section, calibration_page, plain_table
from followspot_calibrate.triangulation import residuals

PAIRS_NOTE = (
    "Moments at which both cameras saw the board, and those that agree on the pose between the two cameras."
)


def page_of(room: str, found: BoardCalibration, planes: Mapping[str, Array], warnings: Sequence[str]) -> Page:
    """The cameras, the pairs that link them, and the residuals of the board's corners in each camera.

    planes: of the room, if its frame of reference stayed.
    """
    apart, pixel = found.distances, found.sightings.pixel
    arrows = residuals(Views(found.cameras), found.points, pixel)
    return calibration_page(
        f"Board of {room}",
        "look" if warnings else "good",
        f"{len(found.cameras)} cameras; lengths on the board are right within {apart.rmse_mm:.2f} mm "
        f"(RMS over {len(apart.printed)} pairs of corners)",
        found.cameras,
        pixel,
        found.points,
        np.where(np.isfinite(found.residual)[..., None], arrows, np.nan),
        planes=planes,
        warnings=warnings,
        more=[_pairs(found)],
    )


def _pairs(found: BoardCalibration) -> Section:
    names = [camera.name for camera in found.cameras]
    rows = [
        [f"{names[a]} – {names[b]}", str(relation.shared), str(relation.moments)]
        for (a, b), relation in found.pairs.items()
    ]
    return plain_table("Pairs", ("cameras", "both saw it", "agree"), rows, note=PAIRS_NOTE)

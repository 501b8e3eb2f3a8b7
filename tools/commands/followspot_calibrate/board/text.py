"""The result of a calibration with a board as a table and as JSON, and its warnings."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from followspot_calibrate.board.solving import BoardCalibration

FEW_MOMENTS = 10
"""Number of views that link a camera below which there is a warning."""
SCALE_DOUBT = 0.02
"""Deviation of the scale from 1 at which the focal lengths are in doubt."""
ROUGH = 1.0
"""RMS error of a camera at which something is in doubt, px."""
CONTRADICTING = 0.15
"""Share of a camera's sightings that were rejected at which something is in doubt."""
FLEXIBLE_MM = 5.0
"""Error of the board's own lengths at which something is in doubt, mm."""


def warnings_of(found: BoardCalibration) -> list[str]:
    """Warnings, each with its remedy."""
    notes = []
    for number, camera in enumerate(found.cameras):
        links = [relation.moments for pair, relation in found.pairs.items() if number in pair]
        if max(links, default=0) < FEW_MOMENTS:
            notes.append(f"{camera.name} is linked by {max(links, default=0)} moments only: show it more")
        if found.rms[number] > ROUGH:
            notes.append(
                f"{camera.name} is off by {found.rms[number]:.1f} px: "
                "calibrate its lens again, or hold the board still"
            )
        share = found.rejected[number] / found.sightings.seen[:, number].sum()
        if share > CONTRADICTING:
            notes.append(
                f"{share:.0%} of the corners in {camera.name} contradict the other cameras: "
                "is it in step with them, did it move?"
            )
    if abs(found.scale - 1) > SCALE_DOUBT:
        notes.append(
            f"lengths by the lenses alone are off by {found.scale - 1:+.1%}: calibrate the lenses again"
        )
    if found.distances.rmse_mm > FLEXIBLE_MM:
        notes.append(
            f"the board's lengths are off by {found.distances.rmse_mm:.1f} mm: "
            "is it flat, does --board have its squares?"
        )
    return notes


def summary(found: BoardCalibration) -> str:
    """A line per camera, then the board's own lengths."""
    lines = [
        f"{camera.name}: {np.isfinite(found.residual[:, i]).sum()} corners, {found.rms[i]:.2f} px RMS, "
        f"at {', '.join(f'{x:.3f}' for x in camera.center)} m"
        for i, camera in enumerate(found.cameras)
    ]
    apart = found.distances
    return "\n".join(
        [
            *lines,
            f"board: lengths off by {apart.rmse_mm:.2f} mm RMS over {len(apart.printed)} pairs of corners, "
            f"{found.rejected.sum()} sightings rejected",
        ]
    )


def as_json(found: BoardCalibration, notes: Sequence[str]) -> str:
    """All figures."""
    names = [camera.name for camera in found.cameras]
    cameras = {
        camera.name: {
            "rotation": camera.rotation.tolist(),
            "translation": camera.translation.tolist(),
            "center": camera.center.tolist(),
            "corners": int(np.isfinite(found.residual[:, i]).sum()),
            "rejected": int(found.rejected[i]),
            "rms_px": float(found.rms[i]),
        }
        for i, camera in enumerate(found.cameras)
    }
    pairs = [
        {"cameras": [names[a], names[b]], "moments": relation.moments, "shared": relation.shared}
        for (a, b), relation in found.pairs.items()
    ]
    return json.dumps(
        {
            "cameras": cameras,
            "pairs": pairs,
            "rigidity_rmse_mm": found.distances.rmse_mm,
            "distances": len(found.distances.printed),
            "rejected": int(found.rejected.sum()),
            "scale": found.scale,
            "warnings": notes,
        }
    )

"""The result of a lens calibration as lines of text with the coverage, and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from followspot_calibrate.intrinsics.calibration import LensCalibration


def summary(done: Mapping[str, LensCalibration]) -> str:
    """A line and the coverage per camera."""
    return "\n".join(_lines(lens) for lens in done.values()) or "no lens was calibrated"


def _lines(lens: LensCalibration) -> str:
    found = lens.fit
    head = (
        f"{lens.camera}: {found.rms:.2f} px RMS in {len(found.views)} of {lens.seen} views, "
        f"focal {found.matrix[0, 0]:.1f} +- {found.sigma[0]:.1f} px, "
        f"covered {lens.coverage.share:.0%}, tilt {lens.tilt:.0f} deg"
    )
    left = [f"{len(x)} {word}" for x, word in ((lens.blurred, "blurred"), (lens.rejected, "outliers")) if x]
    return "\n".join([head + (f" ({', '.join(left)})" if left else ""), *lens.coverage.drawing()])


def as_json(done: Mapping[str, LensCalibration], notes: Mapping[str, Sequence[str]]) -> str:
    """All figures of each camera."""
    return json.dumps({name: {**_fields(lens), "warnings": notes[name]} for name, lens in done.items()})


def _fields(lens: LensCalibration) -> dict[str, Any]:
    found = lens.fit
    return {
        "model": lens.model,
        "size": lens.size,
        "matrix": found.matrix.tolist(),
        "distortion": found.distortion.tolist(),
        "rms_px": found.rms,
        "views": [
            {"frame": view.frame, "corners": len(view.label), "rms_px": float(error)}
            for view, error in zip(found.views, found.per_view, strict=True)
        ],
        "seen": lens.seen,
        "blurred": lens.blurred,
        "rejected": lens.rejected,
        "sigma_focal_px": found.sigma[:2].tolist(),
        "sigma_center_px": found.sigma[2:4].tolist(),
        "tilt_deg": lens.tilt,
        "coverage": {
            "share": lens.coverage.share,
            "missing": lens.coverage.missing,
            "count": lens.coverage.count.tolist(),
        },
    }

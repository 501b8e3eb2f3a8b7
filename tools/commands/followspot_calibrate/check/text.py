"""Findings as tables and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.tables.terminal import table
from followspot_calibrate.check.against import CameraDifference, Comparison
from followspot_calibrate.check.agreement import Agreement
from followspot_calibrate.check.findings import Drift, Findings

CAMERA_HEAD = ("camera", "points", "gross %", "median px", "95 % px", "bias px", "judged px", "limit px", "")
PAIR_NOTE = "median epipolar distance, px"
AGAINST_HEAD = ("camera", "center mm", "angle deg", "mean px", "focal %", "principal px", "lens px")


def as_text(found: Findings) -> str:
    """Tables for people; the verdict ends them."""
    parts = []
    for title, one in (("points", found.points), ("tracked targets", found.tracks)):
        if one is not None:
            parts.append(f"{title}: each camera against the others\n{table(CAMERA_HEAD, camera_rows(one))}")
            parts.append(f"{title}: {PAIR_NOTE}\n{pairs(one)}")
    if found.length is not None:
        one_length = found.length
        parts.append(
            f"known length {1000 * one_length.true_m:.1f} mm: {one_length.mean_mm:.2f} mm, "
            f"sigma {one_length.sigma_mm:.2f} mm, {one_length.count} times"
        )
    if found.comparison is not None:
        parts.append(f"the other calibration minus this one\n{against(found.comparison)}")
    parts += [f"warning: {text}" for text in found.warnings]
    parts += [f"beyond the limit: {text}" for text in found.failures]
    return "\n\n".join([*parts, found.verdict])


def camera_rows(one: Agreement) -> list[tuple[str, ...]]:
    """One line per camera, as `CAMERA_HEAD` says."""
    return [
        (
            figures["camera"],
            str(figures["points"]),
            _text(figures["gross_percent"], 0),
            _text(figures["median_px"]),
            _text(figures["p95_px"]),
            "-" if figures["bias_px"] is None else "{:+.2f} {:+.2f}".format(*figures["bias_px"]),
            _text(figures["judged_px"]),
            _text(figures["limit_px"]),
            "<- look here" if figures["suspect"] else "",
        )
        for figures in camera_figures(one)
    ]


def camera_figures(one: Agreement) -> list[dict[str, Any]]:
    """The figures of cameras in JSON types; None if unknown. Gross errors count in the median only."""
    rows = []
    for number, camera in enumerate(one.cameras):
        length, inliers = one.length[:, number], one.inlier_residual[:, number]
        length, inliers = length[np.isfinite(length)], inliers[np.isfinite(inliers[:, 0])]
        good = np.linalg.norm(inliers, axis=1)
        rows.append(
            {
                "camera": camera.name,
                "points": len(length),
                "gross_percent": _rounded(100 * one.gross[:, number].sum() / len(length))
                if len(length)
                else None,
                "median_px": _rounded(np.median(length)) if len(length) else None,
                "p95_px": _rounded(np.percentile(good, 95)) if len(good) else None,
                "bias_px": [_rounded(x) for x in np.median(inliers, axis=0)] if len(good) else None,
                "judged_px": _rounded(one.score[number]),
                "limit_px": _rounded(one.limit[number]),
                "suspect": number in one.suspects,
            }
        )
    return rows


def pairs(one: Agreement) -> str:
    """The matrix of epipolar distances."""
    names = [camera.name for camera in one.cameras]
    rows = [
        (name, *("" if i == j else _text(_rounded(one.epipolar[i, j])) for j in range(len(names))))
        for i, name in enumerate(names)
    ]
    return table(("", *names), rows)


def against(comparison: Comparison) -> str:
    """One line per camera, and the ratio of the scales."""
    scale = "" if np.isnan(comparison.scale) else f"\n  scale {comparison.scale:.5f}"
    return table(AGAINST_HEAD, against_rows(comparison)) + scale


def against_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """One line per camera, as `AGAINST_HEAD` says."""
    return [
        (
            one.name if one.name == one.other else f"{one.name} ({one.other})",
            _text(_rounded(one.center_mm), 1),
            _text(_rounded(one.angle_deg), 3),
            _text(_rounded(one.mean_px)),
            f"{one.focal_percent:+.2f}",
            f"{one.principal_px:.2f}",
            f"{one.lens_px:.2f}",
        )
        for one in comparison.cameras
    ]


def as_json(found: Findings) -> str:
    """Everything, for scripts; what was not measured is null."""
    return json.dumps(
        {
            "good": not found.failures,
            "verdict": found.verdict,
            "failures": found.failures,
            "warnings": found.warnings,
            "points": _agreement_data(found.points),
            "tracks": _agreement_data(found.tracks),
            "drift": [_drift_data(one) for one in found.drifts],
            "length": None
            if found.length is None
            else {
                "true_mm": 1000 * found.length.true_m,
                "mean_mm": found.length.mean_mm,
                "sigma_mm": found.length.sigma_mm,
                "count": found.length.count,
            },
            "against": _against_data(found.comparison),
        }
    )


def _agreement_data(one: Agreement | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "cameras": camera_figures(one),
        "epipolar_px": _matrix(one.epipolar),
        "shared": one.shared.tolist(),
    }


def _drift_data(one: Drift) -> dict[str, Any]:
    changed = one.change
    return {
        "camera": one.course.camera,
        "time": one.course.time.tolist(),
        "bias_px": one.course.bias.tolist(),
        "change": None
        if changed is None
        else {"at": changed.at, "by_px": changed.by.tolist(), "sigma_px": changed.sigma},
    }


def _against_data(one: Comparison | None) -> dict[str, Any] | None:
    if one is None:
        return None
    cameras = {each.name: _difference(each) for each in one.cameras}
    return {"scale": _rounded(one.scale), "cameras": cameras}


def _difference(one: CameraDifference) -> dict[str, Any]:
    figures = {key: value for key, value in vars(one).items() if key not in ("name", "other")}
    return {"other": one.other, **{key: _rounded(value) for key, value in figures.items()}}


def _matrix(values: Array) -> Sequence[Sequence[float | None]]:
    return [[_rounded(value) for value in row] for row in values]


def _rounded(value: float) -> float | None:
    return round(float(value), 4) if np.isfinite(value) else None


def _text(value: float | None, digits: int = 2) -> str:
    return "-" if value is None else f"{value:.{digits}f}"

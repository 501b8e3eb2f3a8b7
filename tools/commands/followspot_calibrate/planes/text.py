"""Fitted planes as tables and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from followspot.messages import Array
from followspot.tables.terminal import table
from followspot_calibrate.planes.fit import FittedPlane

HEAD = ("plane", "points", "left out", "rms mm", "max mm", "a", "b", "c", "d (m)")


def cells(fits: Sequence[FittedPlane], planes: Mapping[str, Array]) -> list[tuple[str, ...]]:
    """One line per plane that was measured, as `HEAD` says."""
    return [
        (
            fit.name,
            str(int(fit.kept.sum())),
            str(int((~fit.kept).sum())),
            f"{fit.rms_mm:.1f}",
            f"{fit.max_mm:.1f}",
            *(f"{value:+.4f}" for value in planes[fit.name]),
        )
        for fit in fits
    ]


def summary(fits: Sequence[FittedPlane], planes: Mapping[str, Array], floor: str | None) -> str:
    """The table for people."""
    frame = f"\n{floor} is z = 0 now, z up; cameras and planes moved together" if floor else ""
    return table(HEAD, cells(fits, planes)) + frame


def as_json(
    fits: Sequence[FittedPlane], planes: Mapping[str, Array], floor: str | None, warnings: Sequence[str]
) -> str:
    """The fitted planes as JSON, for scripts."""
    measured: dict[str, dict[str, Any]] = {
        fit.name: {
            "plane": planes[fit.name].tolist(),
            "points": int(fit.kept.sum()),
            "left_out": int((~fit.kept).sum()),
            "rms_mm": round(fit.rms_mm, 4),
            "max_mm": round(fit.max_mm, 4),
        }
        for fit in fits
    }
    return json.dumps({"planes": measured, "floor": floor, "warnings": list(warnings)})

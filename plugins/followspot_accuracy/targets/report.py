"""Scores as a table for people and as JSON for programs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from textwrap import dedent
from typing import Any

from followspot.tables import table as drawn
from followspot_accuracy.targets.scoring import TargetScore

HEADINGS = (
    "target",
    "frames",
    "coverage",
    "RMSE",
    "median",
    "p95",
    "switches",
    "false when hidden",
    "recovery",
    "jerk cost",
    "reprojection",
)
TURNED = "orientation"
"""Heading of a further column, if any orientation was scored."""


def table(scores: Mapping[str, TargetScore]) -> str:
    """One line per target under a line of headings; a dash if there was nothing to measure."""
    posed = any(math.isfinite(one.orientation_deg) for one in scores.values())
    rows = [
        (*_cells(name, one), *((_number(one.orientation_deg, ".1f", " deg"),) if posed else ()))
        for name, one in scores.items()
    ]
    return dedent(drawn((*HEADINGS, TURNED) if posed else HEADINGS, rows))


def to_json(scores: Mapping[str, TargetScore]) -> dict[str, dict[str, Any]]:
    """The scores as JSON types; NaN, which JSON has not, becomes null."""
    return {name: {k: _finite(v) for k, v in dataclasses.asdict(one).items()} for name, one in scores.items()}


def _cells(name: str, one: TargetScore) -> tuple[str, ...]:
    worst = f"{one.recovery_worst} frames" if one.recovery_frames else "-"
    false = f"{one.false_positions} of {one.hidden_frames}" if one.hidden_frames else "-"
    spread = f" ± {one.reprojection_std_px:.2f}" if math.isfinite(one.reprojection_std_px) else ""
    return (
        name,
        str(one.frames),
        _number(100 * one.coverage, ".1f", " %"),
        _number(one.rmse_mm, ".1f", " mm"),
        _number(one.median_mm, ".1f", " mm"),
        _number(one.p95_mm, ".1f", " mm"),
        str(one.identity_switches),
        false,
        worst,
        _number(one.jerk_cost, ".4f", ""),
        _number(one.reprojection_px, ".2f", spread + " px"),
    )


def _number(value: float, form: str, unit: str) -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "-"


def _finite(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value

"""Scores as a table for people and as JSON for programs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from textwrap import dedent
from typing import Any

from followspot.tables.terminal import table as drawn
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
RATED = ("within 95 %", "bridged within")
"""Headings of further columns, if any position has an uncertainty."""


def table(scores: Mapping[str, TargetScore]) -> str:
    """One line per target under a line of headings; a dash if there was nothing to measure.

    A last line has the share of errors within the ellipsoid of 95 % of several targets together.
    """
    rated = [one for one in scores.values() if one.rated_frames]
    posed = any(math.isfinite(one.orientation_deg) for one in scores.values())
    heads = (*HEADINGS, *(RATED if rated else ()), *((TURNED,) if posed else ()))
    rows = [
        (
            *_cells(name, one),
            *(_rated_cells(one) if rated else ()),
            *((_number(one.orientation_deg, ".1f", " deg"),) if posed else ()),
        )
        for name, one in scores.items()
    ]
    return dedent(drawn(heads, rows)) + (f"\n{_together(rated)}" if len(rated) > 1 else "")


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


def _rated_cells(one: TargetScore) -> tuple[str, str]:
    bridged = _number(100 * one.bridged_within_95, ".1f", f" % of {one.bridged_frames}")
    return _number(100 * one.within_95, ".1f", " %"), bridged


def _together(rated: Sequence[TargetScore]) -> str:
    """The shares of all targets, over their frames."""
    frames = sum(one.rated_frames for one in rated)
    share = sum(one.within_95 * one.rated_frames for one in rated) / frames
    bridged = [one for one in rated if one.bridged_frames]
    text = f"all targets: {100 * share:.1f} % of {frames} errors within the ellipsoid of 95 %"
    if not bridged:
        return text
    frames = sum(one.bridged_frames for one in bridged)
    share = sum(one.bridged_within_95 * one.bridged_frames for one in bridged) / frames
    return f"{text}, {100 * share:.1f} % of {frames} while bridged"


def _number(value: float, form: str, unit: str) -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "-"


def _finite(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value

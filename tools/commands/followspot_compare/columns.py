"""The figures that are compared, each for one target or for many together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot_compare.trial import TargetFigures

Figures = Sequence[TargetFigures]
"""One for each target."""


@dataclass(frozen=True)
class Column:
    """A figure. of: its value over targets or rooms, NaN if unknown; ratio: True if ratios make sense."""

    key: str
    heading: str
    form: str
    of: Callable[[Sequence[Any]], float]
    ratio: bool = True

    def cell(self, figures: Sequence[Any]) -> str:
        """The value as text, a dash for NaN."""
        value = self.of(figures)
        return self.form.format(value) if math.isfinite(value) else "-"


def mean(values: Sequence[float]) -> float:
    """Mean of what was measured; NaN for nothing."""
    known = [value for value in values if math.isfinite(value)]
    return float(np.mean(known)) if known else math.nan


def finite(value: float) -> float | None:
    """The value for JSON; None for NaN and infinities."""
    return value if math.isfinite(value) else None


def _false_percent(figures: Figures) -> float:
    hidden = sum(f.tracks.hidden_frames for f in figures)
    return 100 * sum(f.tracks.false_positions for f in figures) / hidden if hidden else math.nan


def _false_recoveries(figures: Figures, of: str) -> float:
    """Share of false recoveries in percent. of: "found", all recoveries, or "sought", all frames."""
    whole = sum(getattr(f.recovery, of) for f in figures)
    return 100 * sum(f.recovery.false for f in figures) / whole if whole else math.nan


def _recovery(figures: Figures) -> float:
    """Slowest of all returns, frames."""
    return max((float(frames) for f in figures for frames in f.tracks.recovery_frames), default=math.nan)


def _mean_of(name: str, *, scale: float = 1.0) -> Callable[[Figures], float]:
    """Mean of a figure of the tracks over the targets that were there at all."""
    return lambda figures: scale * mean([getattr(f.tracks, name) for f in figures if f.tracks.frames])


def _mean_of_figure(name: str) -> Callable[[Figures], float]:
    """Likewise of a figure that is no score of the tracks."""
    return lambda figures: mean([getattr(f, name) for f in figures if f.tracks.frames])


def _pairs(place: int) -> Callable[[Figures], float]:
    """Mean over the targets that were there of one figure of the number of pairs."""
    return lambda figures: mean([f.pairs[place] for f in figures if f.tracks.frames])


def _within(share: str, frames: str) -> Callable[[Figures], float]:
    """A share of frames in percent, over the frames of all targets."""

    def percent(figures: Figures) -> float:
        rated = [f.tracks for f in figures if getattr(f.tracks, frames)]
        whole = sum(getattr(one, frames) for one in rated)
        part = sum(getattr(one, share) * getattr(one, frames) for one in rated)
        return 100 * part / whole if whole else math.nan

    return percent


def _switches(figures: Figures) -> float:
    return sum(f.tracks.identity_switches for f in figures)


COLUMNS = (
    Column("coverage_percent", "coverage", "{:.1f} %", _mean_of("coverage", scale=100), ratio=False),
    Column("rmse_mm", "RMSE", "{:.1f} mm", _mean_of("rmse_mm")),
    Column("median_mm", "median", "{:.1f} mm", _mean_of("median_mm")),
    Column("p95_mm", "p95", "{:.1f} mm", _mean_of("p95_mm")),
    Column("within_95_percent", "within 95 %", "{:.1f} %", _within("within_95", "rated_frames"), ratio=False),
    Column(
        "bridged_within_95_percent",
        "bridged within",
        "{:.1f} %",
        _within("bridged_within_95", "bridged_frames"),
        ratio=False,
    ),
    Column("switches", "switches", "{:.0f}", _switches, ratio=False),
    Column("false_percent", "false when hidden", "{:.1f} %", _false_percent, ratio=False),
    Column("recovery_frames", "recovery", "{:.0f} frames", _recovery, ratio=False),
    Column(
        "false_recovery_percent",
        "false recoveries",
        "{:.1f} %",
        lambda figures: _false_recoveries(figures, "found"),
        ratio=False,
    ),
    Column(
        "false_sought_percent",
        "of frames sought",
        "{:.2f} %",
        lambda figures: _false_recoveries(figures, "sought"),
        ratio=False,
    ),
    Column("jerk_cost", "jerk cost", "{:.5f}", _mean_of("jerk_cost")),
    Column("true_jerk_cost", "jerk of truth", "{:.5f}", _mean_of_figure("true_jerk_cost"), ratio=False),
    Column("reprojection_px", "reprojection", "{:.2f} px", _mean_of("reprojection_px")),
    Column("fused_mm", "unfiltered RMSE", "{:.1f} mm", _mean_of_figure("fused_mm")),
    Column("fused_px", "unfiltered reprojection", "{:.2f} px", _mean_of_figure("fused_px")),
    Column("detection_px", "to detections", "{:.2f} px", _mean_of_figure("detection_px")),
    Column("pairs", "pairs", "{:.1f}", _pairs(0), ratio=False),
    Column("pairs_p5", "5 % below", "{:.0f}", _pairs(1), ratio=False),
    Column("pairs_p95", "5 % above", "{:.0f}", _pairs(2), ratio=False),
)
"""All of them, in the order of the table. Several targets: the mean of theirs, but the sum of switches, the
shares of all rated, bridged and hidden frames, recoveries and frames in which one was sought, and the slowest
recovery."""


def measured(groups: Mapping[str, Figures]) -> tuple[Column, ...]:
    """The columns that have a value for any variant."""
    return tuple(c for c in COLUMNS if any(math.isfinite(c.of(figures)) for figures in groups.values()))

"""Plots of a comparison, with matplotlib if it is installed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.errors import writing
from followspot_compare.report import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MISSING = 'no plots: matplotlib is not installed; pip install "followspot[plots]"'
ERRORS = "errors.svg"
ITERATIONS = "iterations.svg"
_PALETTE = ("#1b6ca8", "#e07a1f", "#3d9970", "#b03a48", "#7d5ba6", "#6b6b6b", "#c2a83e", "#4fb3bf")
_LOG_FROM = 20.0
"""Largest over smallest error from which the axis is logarithmic."""


def draw(comparison: Comparison, folder: Path) -> str:
    """Draw errors per target, and iterations if they are known; return a line that names the files.

    The line names the missing package without matplotlib; it is empty if there are no targets. Raises
    FollowspotError if a file cannot be written.
    """
    if not comparison.trackable:
        return ""
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        return MISSING
    drawings = {ERRORS: _errors}
    if _stepping(comparison):
        drawings[ITERATIONS] = _iterations
    with mpl.rc_context({"svg.hashsalt": "followspot", "svg.fonttype": "none", "font.size": 9}):
        for name, drawing in drawings.items():
            figure = Figure(figsize=(max(7.5, 0.55 * len(comparison.trackable)), 3.2), layout="constrained")
            axes = figure.add_subplot()
            axes.spines[["top", "right"]].set_visible(False)
            drawing(axes, comparison)
            figure.legend(loc="outside upper left", ncols=5, frameon=False, fontsize=8)
            with writing(folder / name):
                figure.savefig(folder / name, metadata={"Date": None})
    return "plots: " + ", ".join(str(folder / name) for name in drawings)


def _stepping(comparison: Comparison) -> list[str]:
    """Variants whose fusion iterates."""
    return [v for v in comparison.variants if any(comparison.iterations(v)[1:])]


def _errors(axes: Axes, comparison: Comparison) -> None:
    """RMSE as a bar, the 95th percentile as a tick above it; one cluster per target."""
    targets = comparison.trackable
    width = 0.8 / len(comparison.variants)
    shown = []
    for number, variant in enumerate(comparison.variants):
        figures = [comparison.of_target(*target)[variant] for target in targets]
        rmse = [f[0].tracks.rmse_mm if f else math.nan for f in figures]
        p95 = [f[0].tracks.p95_mm if f else math.nan for f in figures]
        shown += [value for value in rmse if value > 0]
        at = [i + (number - (len(comparison.variants) - 1) / 2) * width for i in range(len(targets))]
        color = _color(comparison, variant)
        axes.bar(at, rmse, 0.9 * width, color=color, label=variant)
        axes.plot(at, p95, "_", color=color, markersize=7)
    if shown and max(shown) > _LOG_FROM * min(shown):
        axes.set_yscale("log")
    several = len(comparison.rooms) > 1
    names = [f"{room}\n{name}" if several else name for room, name in targets]
    axes.set_xticks(range(len(targets)), names, fontsize=7)
    axes.set_ylabel("error, mm (bar: RMSE, tick: p95)")


def _iterations(axes: Axes, comparison: Comparison) -> None:
    """Histogram of steps, like figure 4 of Jin & Qian 2008."""
    variants = _stepping(comparison)
    width = 0.8 / len(variants)
    for number, variant in enumerate(variants):
        counts = comparison.iterations(variant)
        at = [step + (number - (len(variants) - 1) / 2) * width for step in range(len(counts))]
        axes.bar(at, counts, 0.9 * width, color=_color(comparison, variant), label=variant)
    axes.set_xlabel("steps until the centre rests")
    axes.set_ylabel("positions")


def _color(comparison: Comparison, variant: str) -> str:
    return _PALETTE[comparison.variants.index(variant) % len(_PALETTE)]

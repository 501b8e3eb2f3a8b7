"""A plot of a sweep, with matplotlib if it is installed: a figure over each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from followspot.errors import writing
from followspot_sweep.axes import Axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLOT = "sweep.svg"
MISSING = 'no plot: matplotlib is not installed; pip install "followspot[plots]"'
_ALIKE = 0.02
"""Share of a figure by which runs may differ without its being seen."""
_COLORS = ("#1b6ca8", "#e07a1f", "#3d9970", "#b03a48", "#7d5ba6", "#6b6b6b")


def draw(found: Sequence[dict[str, Any]], axes: Sequence[Axis], figure: str, folder: Path) -> str:
    """Draw; return a line that names the file or the missing package."""
    known = [row for row in found if row.get(figure) is not None]
    varied = [axis for axis in axes if len(axis.values) > 1]
    if not known:
        return f'no plot: no run has a figure "{figure}"'
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        return MISSING
    with mpl.rc_context({"svg.hashsalt": "followspot", "svg.fonttype": "none", "font.size": 9}):
        sheet = Figure(figsize=(1.0 + 3.2 * len(varied), 3.2), layout="constrained")
        panels = sheet.subplots(1, len(varied), squeeze=False, sharey=True)[0]
        for panel, axis in zip(panels, varied, strict=True):
            _panel(panel, known, axis, figure)
        panels[0].set_ylabel(figure)
        panels[0].set_ylim(*_span([row[figure] for row in known]))
        panels[0].ticklabel_format(axis="y", useOffset=False)
        panels[0].legend(frameon=False, fontsize=8)
        with writing(folder / PLOT):
            sheet.savefig(folder / PLOT, metadata={"Date": None})
    return f"plot: {folder / PLOT}"


def _span(values: Sequence[float]) -> tuple[float, float]:
    """Limits of the axis around the values; equal values stay in its middle."""
    middle, room = (min(values) + max(values)) / 2, 0.55 * (max(values) - min(values))
    room = max(room, _ALIKE * abs(middle), 1e-9)
    return middle - room, middle + room


def _panel(panel: Axes, known: Sequence[dict[str, Any]], axis: Axis, figure: str) -> None:
    """A dot for each run, and for each room a line through the best of each value."""
    panel.spines[["top", "right"]].set_visible(False)
    panel.set_xlabel(axis.name)
    numeric = all(isinstance(row[axis.name], float) for row in known)
    places: dict[Any, float] = {row[axis.name]: row[axis.name] for row in known}
    if not numeric:
        places = {value: float(number) for number, value in enumerate(dict.fromkeys(places))}
        panel.set_xticks(list(places.values()), [str(value) for value in places])
    for number, room in enumerate(dict.fromkeys(row["room"] for row in known)):
        color = _COLORS[number % len(_COLORS)]
        rows = [row for row in known if row["room"] == room]
        across = [places[row[axis.name]] for row in rows]
        panel.scatter(across, [row[figure] for row in rows], s=9, color=color, alpha=0.4)
        lowest: dict[float, float] = {}
        for place, row in zip(across, rows, strict=True):
            lowest[place] = min(lowest.get(place, row[figure]), row[figure])
        panel.plot(list(lowest), list(lowest.values()), color=color, label=f"{room}, best of the others")

"""Pictures of tracks beside the truth: figures 9 to 11 of Jin & Qian 2008."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from followspot.errors import writing
from followspot.messages import Array
from followspot_accuracy import TrackTable, TruthTable
from followspot_accuracy.targets.scoring import trajectory, with_absent
from followspot_score.plot import MISSING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OVER_TIME = "trajectories.svg"
IN_SPACE = "trajectories_3d.svg"
PALETTE = ("#1b6ca8", "#e07a1f", "#3d9970", "#b03a48", "#7d5ba6", "#6b6b6b", "#c2a83e", "#4fb3bf")
READABLE = {"yellow": "#c9a400", "cyan": "#0097a7", "white": "#999999"}
"""Colors that would be faint on white paper."""
TRUE: dict[str, Any] = {"color": "#555555", "linewidth": 0.6, "linestyle": "--"}
TRACK: dict[str, Any] = {"linewidth": 1.3}
ALONE: dict[str, Any] = {"marker": ".", "markersize": 4, "linestyle": "none"}
Span = tuple[float, float]


def draw_trajectories(tracks: TrackTable, truth: TruthTable, folder: Path, span: Span | None) -> str:
    """Draw positions over time along each axis, and in space; a frame without a position is a gap.

    span: first and last time that is drawn, s; None: all. Returns a line that names the files or the missing
    package. Raises FollowspotError.
    """
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        return MISSING
    shown = within(truth, span)
    paths = [folder / OVER_TIME, folder / IN_SPACE]
    with mpl.rc_context({"svg.hashsalt": "followspot", "svg.fonttype": "none", "font.size": 9}):
        tall, square = (Figure(figsize=size, layout="constrained") for size in ((7.5, 5.0), (5.0, 5.0)))
        _over_time(list(tall.subplots(3, 1, sharex=True)), tracks, shown)
        _in_space(square.add_subplot(projection="3d"), tracks, shown)
        for figure in (tall, square):
            figure.legend(loc="outside upper left", ncols=4, frameon=False, fontsize=8)
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            for figure, path in zip((tall, square), paths, strict=True):
                figure.savefig(path, metadata={"Date": None})
    return "pictures: " + ", ".join(map(str, paths))


def within(truth: TruthTable, span: Span | None) -> TruthTable:
    """The frames of the truth in a span of time, s."""
    first, last = span or (-np.inf, np.inf)
    rows = (truth.time >= first) & (truth.time <= last)
    parts = (truth.xyz[rows], truth.hidden[rows], truth.trackable[rows], truth.pair[rows])
    return TruthTable(truth.objects, truth.time[rows], *parts)


def color_of(name: str, number: int) -> str:
    """The color that a target is named after, else one of the palette."""
    from matplotlib.colors import is_color_like

    named = READABLE.get(name, name)
    return named if is_color_like(named) else PALETTE[number % len(PALETTE)]


def alone(xyz: Array) -> Array:
    """Positions between two frames without one, of which no line can be drawn: (F, 3) m -> (F,) bool."""
    there = np.concatenate([[False], np.isfinite(xyz[:, 0]), [False]])
    return np.asarray(there[1:-1] & ~there[:-2] & ~there[2:])


def _objects(tracks: TrackTable, truth: TruthTable) -> list[tuple[str, str, Array, Array]]:
    """Name, color, positions and true positions of each target, (F, 3) m each, NaN for none."""
    whole = with_absent(truth, [name for name in tracks.objects if name not in truth.objects])
    found = []
    for number, name in enumerate(whole.objects):
        xyz = trajectory(tracks, name, truth.time).xyz
        if np.isfinite(xyz).any() or name in truth.objects:
            found.append((name, color_of(name, number), xyz, whole.xyz[:, number]))
    return found


def _over_time(panels: list[Axes], tracks: TrackTable, truth: TruthTable) -> None:
    """Each coordinate over time, truth dashed."""
    for name, color, xyz, true in _objects(tracks, truth):
        for axis, axes in enumerate(panels):
            label = name if axis == 0 else None
            axes.plot(truth.time, xyz[:, axis], color=color, label=label, **TRACK)
            if (single := alone(xyz)).any():
                axes.plot(truth.time[single], xyz[single, axis], color=color, **ALONE)
            axes.plot(truth.time, true[:, axis], **TRUE)
    for axes, name in zip(panels, "xyz", strict=True):
        axes.set_ylabel(f"{name}, m")
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].plot([], [], label="truth", **TRUE)
    panels[-1].set_xlabel("time, s")


def _in_space(axes: Any, tracks: TrackTable, truth: TruthTable) -> None:
    """The paths in the room, truth dashed."""
    for name, color, xyz, true in _objects(tracks, truth):
        axes.plot(*xyz.T, color=color, label=name, **TRACK)
        axes.plot(*xyz[alone(xyz)].T, color=color, **ALONE)
        axes.plot(*true.T, **TRUE)
    axes.plot([], [], [], label="truth", **TRUE)
    axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_box_aspect(None, zoom=0.8)  # room for the labels

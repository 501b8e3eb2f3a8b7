"""Pictures of poses against the truth: figures 5 and 6 of Weinrich et al. 2010."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from followspot.errors import writing
from followspot_accuracy.persons.errors import PoseErrors, together
from followspot_accuracy.persons.matching import UNMATCHED, match
from followspot_accuracy.persons.scoring import errors_of
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MISSING = 'no pictures: matplotlib is not installed; pip install "followspot[plots]"'
ERRORS = "pose_errors.svg"
PLAN = "floor_plan.svg"
BINS = 41
TRUE, REPORTED = "#9a9a9a", "#1b6ca8"
PANELS = (
    ("direction", "direction, deg", 10.0),
    ("height", "height, m", 0.2),
    ("distance", "distance, m", 1.0),
    ("torso", "torso heading, deg", 180.0),
    ("pan", "head pan, deg", 90.0),
    ("tilt", "head tilt, deg", 90.0),
)
"""Errors, what stands below them, and the end of the axis; errors beyond it are in the last bin."""
ANGLES = ("direction", "torso", "pan", "tilt")


def draw(poses: PoseTable, truth: PoseTruthTable, folder: Path) -> str:
    """Draw into a folder; a line that names the files or the missing package. Raises FollowspotError."""
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        return MISSING
    matches = match(poses, truth)
    errors = together(list(errors_of(poses, truth, matches).values()))
    paths = [folder / ERRORS, folder / PLAN]
    with mpl.rc_context({"svg.hashsalt": "followspot", "svg.fonttype": "none", "font.size": 9}):
        wide, square = (Figure(figsize=size, layout="constrained") for size in ((9.0, 5.0), (5.0, 5.0)))
        _histograms(wide, errors)
        _plan(square.add_subplot(), poses, truth, matches.row)
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            for figure, path in zip((wide, square), paths, strict=True):
                figure.savefig(path, metadata={"Date": None})
    return "pictures: " + ", ".join(map(str, paths))


def _histograms(figure: Figure, errors: PoseErrors) -> None:
    """Signed errors of all persons, one panel a quantity."""
    for axes, (name, label, end) in zip(figure.subplots(2, 3).flat, PANELS, strict=True):
        values = getattr(errors, name)
        values = np.degrees(values) if name in ANGLES else values
        axes.hist(np.clip(values, -end, end), bins=BINS, range=(-end, end), color=REPORTED)
        axes.set_xlabel(f"error of {label}")
        axes.spines[["top", "right"]].set_visible(False)
        if len(values):
            axes.set_title(f"sigma {values.std():.3g}", loc="right", fontsize=8)
    figure.suptitle(f"{len(errors.direction)} poses", fontsize=9)


def _plan(axes: Axes, poses: PoseTable, truth: PoseTruthTable, row: np.ndarray) -> None:
    """Paths on the floor, true and reported; a gap while a person has no pose."""
    for own in range(len(truth.persons)):
        reported = np.where((row[:, own] != UNMATCHED)[:, None], poses.pose[row[:, own], :2], np.nan)
        first = own == 0
        axes.plot(*truth.pose[:, own, :2].T, color=TRUE, label="true" if first else None)
        axes.plot(
            *reported.T,
            ".-",
            color=REPORTED,
            markersize=3,
            linewidth=0.7,
            label="reported" if first else None,
        )
    axes.plot(*truth.viewpoint, "k^", label="viewpoint")
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.legend(frameon=False, fontsize=8)

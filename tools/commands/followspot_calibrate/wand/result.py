"""The result of a wand calibration, as data, as a table and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot.tables.terminal import table
from followspot_calibrate.wand.alignment import Alignment
from followspot_calibrate.wand.rods import measured
from followspot_calibrate.wand.solving import Solved
from followspot_calibrate.wand.targets import Refined


@dataclass(frozen=True, eq=False)
class Calibrated:
    """Cameras and points in the frame of the room; warnings are sentences for the user.

    cameras: by name; points: (N, 3) m, or in an arbitrary unit if the alignment is not metric; targets:
    result of the targets' clips, if there were any.
    """

    solved: Solved
    alignment: Alignment
    cameras: Mapping[str, Camera]
    points: Array
    warnings: Sequence[str]
    targets: Refined | None = None

    @property
    def mean_px(self) -> float:
        """Mean reprojection error of the sightings that count."""
        return float(np.nanmean(self.solved.adjusted.distance))

    @property
    def lengths(self) -> Array | None:
        """The wand's length in the frames that show it whole, m; None for one bulb."""
        rods = self.solved.rods
        if rods is None:
            return None
        found = measured(self.points, rods)
        return found[np.isfinite(found)]


def summary(result: Calibrated) -> str:
    """A table per camera, the points that pairs share, and what gave the frame of reference."""
    head = ("camera", "points", "left out", "mean px", "median", "p95", "focal px")
    rows = [
        (
            name,
            str(one["points"]),
            str(one["left_out"]),
            *(f"{one[key]:.3f}" for key in ("mean_px", "median_px", "p95_px")),
            f"{one['focal_px']:.1f}",
        )
        for name, one in _figures(result).items()
    ]
    pairs = table(("", *result.cameras), shared_points(result))
    parts = [table(head, rows), "points that pairs share\n" + pairs]
    parts.append("\n".join(f"{what}: {value}" for what, value in notes_of(result)))
    return "\n\n".join(parts)


def shared_points(result: Calibrated) -> list[tuple[str, ...]]:
    """One line per camera: the points that it shares with each other one."""
    shared = {frozenset((pair.first, pair.second)): str(pair.shared) for pair in result.solved.pairs}
    numbers = range(len(result.cameras))
    return [
        (name, *(shared.get(frozenset((i, j)), "-") for j in numbers))
        for i, name in enumerate(result.cameras)
    ]


def as_json(result: Calibrated) -> str:
    """The result as JSON, for scripts."""
    names, distance = list(result.cameras), result.solved.adjusted.distance
    rms, lengths = result.alignment.rms, result.lengths
    return json.dumps(
        {
            "cameras": _figures(result),
            "pairs": [
                {"first": names[pair.first], "second": names[pair.second], "shared": pair.shared}
                for pair in result.solved.pairs
            ],
            "mean_px": float(np.nanmean(distance)),
            "median_px": float(np.nanmedian(distance)),
            "intrinsics": result.solved.intrinsics,
            "late_frames": dict(zip(names, result.solved.timed.late.tolist(), strict=True)),
            "align": result.alignment.method,
            "align_rms_mm": None if rms is None else 1000 * rms,
            "metric": result.alignment.metric,
            "wand_mm": None
            if lengths is None
            else [1000 * float(lengths.mean()), 1000 * float(lengths.std())],
            "targets": None
            if result.targets is None
            else {"points": result.targets.points, "mean_px": result.targets.mean_px},
            "warnings": list(result.warnings),
        }
    )


def _figures(result: Calibrated) -> dict[str, dict[str, Any]]:
    adjusted, seen = result.solved.adjusted, result.solved.sightings.seen
    figures = {}
    for number, (name, camera) in enumerate(result.cameras.items()):
        errors = adjusted.distance[adjusted.used[:, number], number]
        median, p95 = np.percentile(errors, [50, 95]) if len(errors) else (np.nan, np.nan)
        figures[name] = {
            "points": len(errors),
            "left_out": int(seen[:, number].sum()) - len(errors),
            "mean_px": float(errors.mean()),
            "median_px": float(median),
            "p95_px": float(p95),
            "focal_px": float(camera.matrix[0, 0]),
        }
    return figures


def notes_of(result: Calibrated) -> list[tuple[str, str]]:
    """Notes beside the tables, by subject: the errors, the intrinsics, the frame and the scale."""
    intrinsics = {
        "known": "kept as the room has them",
        "refined": "of the room, refined: they fit the points clearly better",
        "free": "found from the points",
    }
    distance, alignment = result.solved.adjusted.distance, result.alignment
    frame = "its own, origin in the middle of the cameras"
    if alignment.rms is not None:
        frame = f"known {alignment.method} met within {1000 * alignment.rms:.1f} mm (RMS)"
    lines = [
        ("reprojection", f"mean {np.nanmean(distance):.3f} px, median {np.nanmedian(distance):.3f} px"),
        ("intrinsics", intrinsics[result.solved.intrinsics]),
        ("frame of reference", frame),
    ]
    targets, lengths = result.targets, result.lengths
    if targets is not None:
        seen = f"{targets.points} places, {targets.sightings} sightings, mean {targets.mean_px:.3f} px"
        lines.append(("targets", seen))
    if lengths is not None:
        lines.append(("wand", f"{1000 * lengths.mean():.2f} mm, sigma {1000 * lengths.std():.2f} mm"))
    return lines
